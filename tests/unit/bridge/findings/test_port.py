from __future__ import annotations

import errno

import pytest

from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.port import open_error_finding, port_finding
from rostether.errors import ConfigError, TransportOpenError
from rostether.transports.port_facts import PortFacts
from rostether.transports.port_holders import Holder

PORT = "/dev/ttyACM0"


def reported(facts: PortFacts) -> str:
    finding = port_finding(facts)
    assert finding is not None
    return f"{finding.code}: {finding}"


def test_a_good_port() -> None:
    assert port_finding(PortFacts(PORT)) is None


def test_a_port_that_is_not_there() -> None:
    alone = reported(PortFacts(PORT, exists=False))
    assert alone.startswith("no-port: there is no port /dev/ttyACM0")
    assert "carries data" in alone
    near = reported(
        PortFacts(PORT, exists=False, near=("/dev/ttyACM1 (Arduino Uno)",), others=("/dev/ttyS0",))
    )
    assert "did you mean /dev/ttyACM1 (Arduino Uno)?" in near
    assert "the ports are /dev/ttyS0" in reported(PortFacts(PORT, exists=False, others=("/dev/ttyS0",)))


def test_mistyped_names_of_ports() -> None:
    others = ("/dev/ttyS0",)
    mistyped = reported(PortFacts("/dev/ttyACMO", exists=False, others=others))
    assert "did you mean /dev/ttyACM0 (with a zero)?" in mistyped
    assert "a port's name on Windows" in reported(PortFacts("COM3", exists=False, others=others))


def test_permission_with_the_exact_command() -> None:
    assert "run: sudo usermod -aG dialout $USER" in reported(PortFacts(PORT, may_open=False, group="dialout"))
    assert f"run: sudo chmod a+rw {PORT}" in reported(PortFacts(PORT, may_open=False))


def test_programs_that_use_a_port() -> None:
    line = reported(PortFacts(PORT, holders=(Holder(4711, "screen"), Holder(4712, "cat"))))
    assert "screen (PID 4711), cat (PID 4712)" in line
    assert "kill 4711 4712" in line


def test_no_port_at_all() -> None:
    assert reported(PortFacts("/tmp", is_device=False)).startswith("not-a-port")


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        (errno.ENOENT, Code.NO_PORT),
        (errno.ENXIO, Code.NO_PORT),
        (errno.EACCES, Code.NO_PERMISSION),
        (errno.EPERM, Code.NO_PERMISSION),
        (errno.EBUSY, Code.BUSY),
        (errno.ENOTTY, Code.NOT_A_PORT),
        (errno.EIO, Code.CANNOT_OPEN),
    ],
)
def test_why_a_port_did_not_open(code: int, expected: Code) -> None:
    failure = TransportOpenError("cannot open it; do something")
    failure.__cause__ = OSError(code, "reason")
    finding = open_error_finding(failure)
    assert finding.code is expected
    assert finding.next_step


def test_an_unsupported_baud_rate_is_no_fault_of_the_port() -> None:
    failure = ConfigError("/dev/ttyACM0 does not support 3 baud; choose another with ?baud=57600")
    failure.__cause__ = OSError(errno.EINVAL, "Invalid argument")
    finding = open_error_finding(failure)
    assert (finding.code, finding.next_step) == (Code.CANNOT_OPEN, "choose another with ?baud=57600")


def test_a_failure_is_shown_with_its_own_text() -> None:
    finding = open_error_finding(TransportOpenError("robot:11411 refuses; start it"))
    assert (finding.code, finding.seen, finding.next_step) == (
        Code.CANNOT_OPEN,
        "robot:11411 refuses",
        "start it",
    )
