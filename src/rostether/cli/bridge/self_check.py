"""`rostether self-check`: which optional parts work on this machine, and how to get the others."""

from __future__ import annotations

import importlib.metadata
import shutil
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

from msgspec import Struct

from rostether.cli.shell.output import json_option, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import BoardError, ConfigError, RostetherError
from rostether.extras import install_command
from rostether.mechanisms.text import read_failure

# Each extra: a module that it installs, the distribution of that module, and the purpose.
_EXTRAS = (
    ("zenoh", "zenoh", "eclipse-zenoh", "ROS 2 over zenoh"),
    ("rclpy", "rclpy", "ros-rclpy", "ROS 2 over an installed rclpy"),
    ("rosbridge", "cbor2", "cbor2", "web pages over rosbridge"),
    ("tls", "cryptography", "cryptography", "certificates for --tls auto"),
    ("mdns", "zeroconf", "zeroconf", "boards on the network find the bridge"),
    ("recording", "lz4", "lz4", "compressed recordings"),
    ("parquet", "pyarrow", "pyarrow", "export to Parquet"),
    ("pictures", "resvg_py", "resvg-py", "pictures as PNG"),
    ("camera", "PIL", "pillow", "cameras and test pictures"),
    ("detection", "cv2", "opencv-python-headless", "objects in the pictures of cameras"),
    ("gps", "pynmea2", "pynmea2", "GPS receivers"),
    ("gpio", "gpiod", "gpiod", "GPIO lines as sensors"),
    ("robot", "xacro", "xacro", "xacro files"),
    ("uvloop", "uvloop", "uvloop", "a faster event loop"),
)
_BROWSERS = ("chromium", "google-chrome", "firefox", "xdg-open")
# More would not fit on the line; `rostether ports` lists all.
_SHOWN_PORTS = 4


class OptionalPart(Struct, frozen=True):
    """One optional part: its name, its purpose, what was found (empty if nothing), and the next step."""

    part: str
    purpose: str
    found: str = ""
    next_step: str = ""


@verb("self-check", "rostether self-check\nrostether self-check --json")
@json_option
def self_check(as_json: bool) -> None:
    """Show which optional parts of rostether work on this machine, and how to get the others.

    The command connects to no graph and no board. To diagnose a board, use `rostether doctor`.
    """
    for each in optional_parts():
        if as_json:
            write_json(
                {
                    "part": each.part,
                    "purpose": each.purpose,
                    "works": bool(each.found),
                    "found": each.found or None,
                    "next_step": each.next_step or None,
                }
            )
        else:
            write_line(
                f"{'yes' if each.found else 'no':<4} {each.part:<16} {each.purpose:<40} {each.found}".rstrip()
            )
            if not each.found:
                write_line(f"     {each.next_step}")


def optional_parts() -> Iterator[OptionalPart]:
    """Search for each optional part and yield what was found, extras first."""
    for extra, module, distribution, purpose in _EXTRAS:
        yield _extra(extra, module, distribution, purpose)
    yield _checked("avr-gcc", "sketches for AVR boards", _find_compiler)
    yield _program(
        "arduino-cli", "sketches for other boards", "install it: https://arduino.github.io/arduino-cli"
    )
    yield _program("avrdude", "flashing AVR boards", "on Debian and Ubuntu: sudo apt install avrdude")
    yield _checked("simavr", "simulated AVR boards", _find_simavr)
    yield _program(
        "qemu-system-arm",
        "simulated Cortex-M boards",
        "on Debian and Ubuntu: sudo apt install qemu-system-arm",
    )
    yield _program("g++", "simulated OpenCR boards", "on Debian and Ubuntu: sudo apt install g++")
    yield _checked("serial ports", "boards on serial ports", _find_ports)
    yield _checked("browser", "the dashboard on this machine", _find_browser)
    if sys.platform == "linux":
        yield _checked("systemd", "start at boot", _find_systemd)
    yield _checked("multicast", "robots of a fleet", _find_multicast)


def _extra(extra: str, module: str, distribution: str, purpose: str) -> OptionalPart:
    if find_spec(module) is None:
        return OptionalPart(extra, purpose, next_step=f"run: {install_command(extra)}")
    try:
        return OptionalPart(extra, purpose, f"{distribution} {importlib.metadata.version(distribution)}")
    except importlib.metadata.PackageNotFoundError:
        # The module belongs to a sourced ROS 2, or to the system.
        return OptionalPart(extra, purpose, f"{module}, not installed by pip")


def _program(name: str, purpose: str, next_step: str) -> OptionalPart:
    return OptionalPart(name, purpose, shutil.which(name) or "", next_step)


def _checked(part: str, purpose: str, find: Callable[[], str]) -> OptionalPart:
    """Return the part with the result of a search; the text of its error is the next step."""
    try:
        return OptionalPart(part, purpose, find())
    except RostetherError as error:
        return OptionalPart(part, purpose, next_step=str(error))
    except OSError as error:
        # For example, a folder of the Arduino core that this user may not search.
        return OptionalPart(part, purpose, next_step=read_failure(error.filename, error))


def _find_compiler() -> str:
    from rostether.firmware.toolchain import find_avr_toolchain

    toolchain = find_avr_toolchain()
    return f"{toolchain.tools}/avr-gcc, core {toolchain.core}"


def _find_simavr() -> str:
    from rostether.simulation.simavr.compile import missing_parts

    if missing := missing_parts():
        raise BoardError(missing)
    return "libsimavr and a C compiler"


def _find_multicast() -> str:
    import socket

    from rostether.platform.multicast_socket import REFERENCE_GROUP

    # Joins the group on the interface that the system chooses; no datagram is sent to it.
    group = socket.inet_aton(REFERENCE_GROUP) + bytes(4)
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    except OSError as error:
        raise ConfigError(
            f"cannot join {REFERENCE_GROUP}: {error.strerror}; connect this machine to a network"
        ) from None
    return f"{REFERENCE_GROUP} can be joined"


def _find_systemd() -> str:
    if not Path("/run/systemd/system").is_dir():
        raise ConfigError("nothing to do, unless `rostether up` must start at boot: use a Linux with systemd")
    return "runs"


def _find_ports() -> str:
    from rostether.transports.port_facts import may_open
    from rostether.transports.serial import list_ports
    from rostether.transports.serial_errors import explain_permission

    ports = list_ports()
    if not ports:
        raise ConfigError("no port found; connect a board with a USB cable")
    denied = [port.path for port in ports if not may_open(port.path)]
    if denied:
        raise ConfigError(explain_permission(denied[0]))
    return ", ".join(port.path for port in ports[:_SHOWN_PORTS])


def _find_browser() -> str:
    for name in _BROWSERS:
        if path := shutil.which(name):
            return path
    if sys.platform in ("darwin", "win32"):
        return "the system's"
    raise ConfigError("open the dashboard's address on a phone or another machine")
