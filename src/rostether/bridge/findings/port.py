"""Problems of a port before the first byte: from its facts, or from the error of opening it."""

from __future__ import annotations

import errno
import sys

from rostether.bridge.findings.finding import Code, Finding, error, split_step
from rostether.errors import ConfigError
from rostether.transports.address_advice import WINDOWS_PORT, meant_port
from rostether.transports.port_facts import PortFacts
from rostether.transports.port_holders import Holder
from rostether.transports.serial_errors import permission_problem

_OPEN_CODES = {
    errno.ENOENT: Code.NO_PORT,
    errno.ENXIO: Code.NO_PORT,
    errno.ENODEV: Code.NO_PORT,
    errno.EACCES: Code.NO_PERMISSION,
    errno.EPERM: Code.NO_PERMISSION,
    errno.EBUSY: Code.BUSY,
    errno.ENOTTY: Code.NOT_A_PORT,
    errno.EISDIR: Code.NOT_A_PORT,
    errno.EINVAL: Code.NOT_A_PORT,
}


def port_finding(facts: PortFacts) -> Finding | None:
    """Return why a port cannot or should not be used now, None if no problem is known."""
    if not facts.exists:
        return _no_port(facts)
    if not facts.is_device:
        return error(
            Code.NOT_A_PORT,
            f"{facts.path} is not a serial port",
            "give the board's port; rostether ports lists all ports",
        )
    if not facts.may_open:
        return error(Code.NO_PERMISSION, *permission_problem(facts.path, facts.group))
    return busy(facts.path, facts.holders) if facts.holders else None


def open_error_finding(failure: BaseException) -> Finding:
    """Return why a port did not open; `failure` was raised from the system's error if there is one."""
    reason = failure.__cause__
    code = Code.CANNOT_OPEN
    # The system reports an unsupported baud rate with the same number as a file that is not a port.
    if isinstance(reason, OSError) and not isinstance(failure, ConfigError):
        code = _OPEN_CODES.get(reason.errno or 0, code)
    return cannot_open(failure, code)


def cannot_open(failure: BaseException, code: Code = Code.CANNOT_OPEN) -> Finding:
    """Return the finding for a link that did not open, with the failure's text."""
    return error(code, *split_step(str(failure), "check the address"))


def busy(port: str, holders: tuple[Holder, ...]) -> Finding:
    """Return the finding for a port or address that other programs use."""
    who = ", ".join(map(str, holders))
    pids = " ".join(str(each.pid) for each in holders)
    return error(
        Code.BUSY,
        f"{port} is in use by {who}: two programs that read one port each get only some of the bytes",
        f"close it, or run: kill {pids}",
    )


def _no_port(facts: PortFacts) -> Finding:
    if (meant := meant_port(facts.path)) is not None:
        step = f"did you mean {meant}?"
    elif WINDOWS_PORT.fullmatch(facts.path) and sys.platform != "win32":
        step = "this is a port's name on Windows; here it is /dev/ttyACM0 or /dev/ttyUSB0"
    elif facts.near:
        step = f"did you mean {' or '.join(facts.near)}?"
    elif facts.others:
        step = f"the ports are {', '.join(facts.others)}"
    else:
        step = (
            "no serial port found; plug in the board with a USB cable that carries data (many only charge),"
            " and check dmesg"
        )
    return error(Code.NO_PORT, f"there is no port {facts.path}", step)
