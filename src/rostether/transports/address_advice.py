"""Advice on what to write instead of an invalid link address, or of a mistyped serial port."""

from __future__ import annotations

import re
import shlex
import stat
import sys
import unicodedata
from collections.abc import Sequence
from pathlib import Path

from rostether.errors import ConfigError
from rostether.transports.address import Address, SerialAddress, XbeeAddress
from rostether.transports.serial_port import ListPorts, SerialPort

MAX_PORT = 65535
WINDOWS_PORT = re.compile(r"(?:\\\\\.\\)?COM[0-9]+", re.IGNORECASE)

_HOST_PORT = re.compile(r"[^\s:/]+:[0-9]{1,5}")
_IPV4 = re.compile(r"[0-9]{1,3}(?:\.[0-9]{1,3}){3}")
# `/dev/ttyACM0:115200`, as other programs write it.
_PORT_AND_BAUD = re.compile(r"(.*[^:,@])[:,@]([1-9][0-9]{2,6})")
_NUMBERED = re.compile(r"/?dev/(tty)?(ACM|USB|AMA|S)([0-9OIl]*)", re.IGNORECASE)
_DIGITS = str.maketrans("OoIl", "0011")
_SKETCH_SUFFIXES = (".ino", ".elf", ".hex")


def address_advice(text: str) -> str | None:
    """Return what to write instead of a text without a link type, None for an unknown link type."""
    if (meant := baud_option(text)) is not None:
        return f"write {meant}"
    if _HOST_PORT.fullmatch(text):
        return f"write tcp://{text}?connect=yes to connect there, or tcp://{text} to listen there"
    if ":" in text:
        return None
    if is_number(text):
        baud = f"for a baud rate, write it after the port: /dev/ttyACM0?baud={text}"
        listening = f"; to listen on that TCP port, write tcp://:{text}"
        return baud + (listening if int(text) <= MAX_PORT else "")
    if _IPV4.fullmatch(text):
        return (
            "boards connect to this machine: write tcp://:11411, and give them this machine's address; "
            f"to connect to a board, write tcp://{text}:PORT?connect=yes"
        )
    if text.lower().endswith(_SKETCH_SUFFIXES):
        return sketch_advice(text)
    example = f"/dev/{text}" if text.startswith(("tty", "cu.")) else "/dev/ttyACM0"
    return f"write a serial port with its path, such as {example} (`rostether ports` lists them)"


def baud_option(text: str) -> str | None:
    """Return the address that is meant by a port and a baud rate such as ttyACM0:115200, None for others."""
    match = _PORT_AND_BAUD.fullmatch(text)
    if match is None or not ("tty" in match[1] or "/cu." in match[1] or WINDOWS_PORT.fullmatch(match[1])):
        return None
    folder = "/dev/" if match[1].startswith("tty") else ""
    return f"{folder}{match[1]}?baud={match[2]}"


def sketch_advice(text: str) -> str:
    """Return what to do with a sketch where a link address belongs."""
    command = f"rostether flash {shlex.quote(text)}"
    return f"write {shlex.quote(f'sim:{text}')} for a simulated board; `{command}` flashes and serves a board"


def is_number(text: str) -> bool:
    """Return whether a text is a whole number of a length that Python converts."""
    return text.isascii() and text.isdigit() and len(text) <= 20


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
    if (with_baud := baud_option(path)) is not None:
        return with_baud
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
