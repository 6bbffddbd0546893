"""Problems of a port before the first byte: from its facts, or from the error of opening it."""

from __future__ import annotations

import errno
import sys

from rostether.bridge.findings.finding import Code, Finding, error, split_step
from rostether.transports.address_advice import WINDOWS_PORT, meant_port
from rostether.transports.port_facts import PortFacts
from rostether.transports.port_holders import Holder
from rostether.transports.serial_errors import permission_problem


def port_findings(facts: PortFacts) -> list[Finding]:
    """Return why a port cannot or should not be used now; empty if no problem is known."""
    if not facts.exists:
        return [_no_port(facts)]
    if not facts.is_device:
        return [
            error(
                Code.NOT_A_PORT,
                f"{facts.path} is not a serial port",
                "give the board's port; rostether ports lists all ports",
            )
        ]
    if not facts.may_open:
        return [error(Code.NO_PERMISSION, *permission_problem(facts.path, facts.group))]
    if facts.holders:
        return [busy(facts.path, facts.holders)]
    return []


def open_error_finding(facts: PortFacts, failure: BaseException) -> Finding:
    """Return why a port did not open; `failure` was raised from the system's error if there is one."""
    reason = failure.__cause__ if isinstance(failure.__cause__, OSError) else failure
    code = reason.errno if isinstance(reason, OSError) else None
    if code in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
        return _no_port(facts)
    if code in (errno.EACCES, errno.EPERM):
        return error(Code.NO_PERMISSION, *permission_problem(facts.path, facts.group))
    if code == errno.EBUSY:
        return busy(facts.path, facts.holders)
    if code in (errno.ENOTTY, errno.EISDIR, errno.EINVAL):
        return error(Code.NOT_A_PORT, f"{facts.path} is not a serial port", "rostether ports lists all ports")
    return cannot_open(failure)


def cannot_open(failure: BaseException) -> Finding:
    """Return the finding for any other failure, with the failure's text."""
    return error(Code.CANNOT_OPEN, *split_step(str(failure), "check the address"))


def busy(port: str, holders: tuple[Holder, ...]) -> Finding:
    """Return the finding for a port or address that other programs use."""
    if not holders:
        return error(
            Code.BUSY,
            f"{port} is in use by another program",
            "close the Arduino IDE's monitor, or a second bridge",
        )
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
