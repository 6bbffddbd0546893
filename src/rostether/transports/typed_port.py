"""Finds the serial port that a mistyped name means, to report it instead of waiting for the port."""

from __future__ import annotations

import re
import stat
import sys
import unicodedata
from collections.abc import Sequence
from pathlib import Path

from rostether.errors import ConfigError
from rostether.transports.address import Address, SerialAddress, XbeeAddress
from rostether.transports.address_advice import WINDOWS_PORT, baud_option, sketch_advice
from rostether.transports.serial_port import ListPorts, SerialPort

_NUMBERED = re.compile(r"/?dev/(tty)?(ACM|USB|AMA|S)([0-9OIl]*)", re.IGNORECASE)
_DIGITS = str.maketrans("OoIl", "0011")


def check_typed_port(address: Address, list_ports: ListPorts) -> None:
    """Raise ConfigError for a serial port that cannot appear: a typing error, a file, a folder."""
    if not isinstance(address, SerialAddress | XbeeAddress) or sys.platform == "win32":
        return
    path = address.path
    try:
        mode = Path(path).stat().st_mode
    except OSError:
        if WINDOWS_PORT.fullmatch(path):
            raise ConfigError(
                f"{path} is a port's name on Windows; here it is {_plugged_in(list_ports())}"
            ) from None
        if (meant := meant_port(path)) is not None:
            raise ConfigError(f"no serial port {path}; did you mean {meant}?") from None
        # Names of ports have ASCII characters only; a copied text may have others that look alike.
        strange = next((each for each in path if not each.isascii()), None)
        if strange is not None and path.startswith("/dev/"):
            name = unicodedata.name(strange, "not a letter")
            raise ConfigError(f"no serial port {path}; {strange!r} is {name}; type it again") from None
        return
    if stat.S_ISREG(mode) or stat.S_ISDIR(mode):
        if path.endswith(".ino") or any(Path(path).glob("*.ino")):
            raise ConfigError(f"{path} is a sketch, not a serial port; {sketch_advice(path)}")
        kind = "folder" if stat.S_ISDIR(mode) else "file"
        raise ConfigError(f"{path} is a {kind}, not a serial port; write {_plugged_in(list_ports())}")


def meant_port(path: str) -> str | None:
    """Return the port that a mistyped name probably means."""
    return baud_option(path) or _meant(path)


def _meant(path: str) -> str | None:
    match = _NUMBERED.fullmatch(path)
    if match is None:
        return None
    meant = f"/dev/tty{match[2].upper()}{match[3].translate(_DIGITS) or '0'}"
    if meant == path:
        return None
    return f"{meant} (with a zero)" if "O" in match[3].upper() else meant


def _plugged_in(ports: Sequence[SerialPort]) -> str:
    # Every PC has the ports of the mainboard, which have no board.
    plugged_in = [each.path for each in ports if not each.path.startswith("/dev/ttyS")]
    return " or ".join(plugged_in[:3]) or "/dev/ttyACM0 or /dev/ttyUSB0 (none is plugged in now)"
