from __future__ import annotations

from pathlib import Path

import pytest

from rostether.bridge.findings.finding import Code, Severity, error, warning

TESTS = Path(__file__).parents[3]
# The test that causes each finding as in real use, and the text that it expects.
FIRMWARE = TESTS / "firmware" / "findings" / "test_real_causes.py"
PROCESS = TESTS / "unit" / "cli" / "bridge" / "test_doctor.py"
ELSEWHERE = {
    Code.NO_PORT: (PROCESS, "error no-port"),
    Code.NOT_A_PORT: (PROCESS, "error not-a-port"),
    Code.NO_PERMISSION: (PROCESS, "error no-permission"),
    Code.BUSY: (PROCESS, "error busy"),
    Code.CANNOT_OPEN: (PROCESS, "error cannot-open"),
    Code.NOBODY_CONNECTED: (PROCESS, "error nobody-connected"),
    Code.MESSAGES_LOST: (TESTS / "interop" / "test_diagnostics_ros1.py", "finding messages-lost"),
    Code.RADIO_LOSS: (TESTS / "unit" / "simulation" / "xbee" / "test_network.py", "finding radio-loss"),
    Code.MISSING_TOPIC: (
        TESTS / "unit" / "cli" / "bridge" / "test_serial_node.py",
        "does not announce imu, which devices.toml requires",
    ),
}
PAGE = Path(__file__).parents[4] / "docs" / "how-to" / "when-a-board-does-not-connect.md"


def test_one_line_has_the_finding_and_a_hint() -> None:
    finding = error(Code.BUSY, "the port is in use", "close the monitor")
    assert str(finding) == "the port is in use; close the monitor"
    assert finding.severity is Severity.ERROR
    assert warning(Code.BUSY, "", "").severity is Severity.WARN


def test_a_finding_stays_the_same_while_its_figures_change() -> None:
    first = warning(Code.FRAMES_DAMAGED, "1 % of the frames", "check the cable")
    second = warning(Code.FRAMES_DAMAGED, "2 % of the frames", "check the cable")
    assert first.key == second.key
    assert first.key != warning(Code.BUFFER_TOO_SMALL, "", "", "chatter").key


@pytest.mark.parametrize("code", Code)
def test_every_finding_has_a_test_with_its_real_cause(code: Code) -> None:
    file, sign = ELSEWHERE.get(code, (FIRMWARE, f"[Code.{code.name}"))
    assert sign in file.read_text()


def test_every_finding_is_in_the_documentation() -> None:
    listed = {line.split("`")[1] for line in PAGE.read_text().splitlines() if line.startswith("| `")}
    assert listed == {str(code) for code in Code}
