"""Explains why a serial port cannot be opened, with the next step."""

from __future__ import annotations

import errno
import os
import re
import sys

from rostether.errors import ConfigError, RostetherError, TransportOpenError
from rostether.mechanisms.text import listed
from rostether.transports.address import SerialAddress
from rostether.transports.port_facts import LISTED_PORTS, group_of
from rostether.transports.port_holders import find_holders, is_open_here
from rostether.transports.serial_port import ListPorts

_PTY_NAME = re.compile(r"/dev/pts/[0-9]+|/dev/tty[p-za-e][0-9a-f]|/dev/ttys[0-9]{3,}")


def is_pseudo_terminal(path: str) -> bool:
    """Return whether a path is a pseudo-terminal's slave, perhaps through links."""
    return _PTY_NAME.fullmatch(os.path.realpath(path)) is not None


def explain_open_error(address: SerialAddress, error: Exception, list_ports: ListPorts) -> RostetherError:
    """Return the error to raise for a port that did not open."""
    path = address.path
    code = error.errno if isinstance(error, OSError) else None
    if isinstance(error, PermissionError) and sys.platform == "win32":
        code = errno.EBUSY  # Windows reports "access denied" for a port that another program has open
    if isinstance(error, FileNotFoundError):
        return TransportOpenError(f"no serial port {path}; {_describe_ports(list_ports)}")
    if code == errno.EBUSY:
        holder = find_holder(path) or "another program, such as the Arduino IDE's serial monitor"
        return TransportOpenError(f"{path} is in use by {holder}; close that program")
    if isinstance(error, PermissionError):
        return TransportOpenError(explain_permission(path))
    if code in (errno.ENOTTY, errno.EISDIR) or (code == errno.EINVAL and not _is_terminal(path)):
        return TransportOpenError(f"{path} is not a serial port; {_describe_ports(list_ports)}")
    if isinstance(error, OSError) and code in (errno.ENXIO, errno.ENODEV, errno.EIO):
        return TransportOpenError(f"no device answers on {path}; {_describe_ports(list_ports)}")
    if isinstance(error, OSError) and code != errno.EINVAL:
        return TransportOpenError(
            f"cannot open {path}: {error.strerror or error}; unplug it and plug it in again"
        )
    return ConfigError(
        f"{path} does not support {address.baud} baud ({error}); choose another with ?baud=57600"
    )


def _is_terminal(path: str) -> bool:
    """Return whether a device is a serial line; /dev/urandom refuses all settings with the same error."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    except OSError:
        return True
    try:
        return os.isatty(descriptor)
    finally:
        os.close(descriptor)


def find_holder(path: str) -> str | None:
    """Return the process that has a port open, if the system shows it: `screen (PID 4711)`."""
    holders = find_holders(path)
    if holders:
        return str(holders[0])
    return "this program" if is_open_here(path) else None


def explain_permission(path: str) -> str:
    """Return who may open a port, and the command that permits it, as one line."""
    return "; ".join(permission_problem(path, group_of(path)))


def permission_problem(path: str, group: str | None) -> tuple[str, str]:
    """Return who may open a port, and the command that permits it; `group` is that of `PortFacts`."""
    if group is None:
        return f"no permission to open {path}: only root may use it", f"run: sudo chmod a+rw {path}"
    return (
        f"no permission to open {path}: it belongs to group {group}, and you are not in it",
        f"run: sudo usermod -aG {group} $USER, then log out and in again",
    )


def _describe_ports(list_ports: ListPorts) -> str:
    ports = list_ports()
    if not ports:
        return "no serial port found; plug in the board"
    return f"choose from: {listed([f'{port.path} ({port.description})' for port in ports], LISTED_PORTS)}"
