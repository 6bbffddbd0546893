from __future__ import annotations

from pathlib import Path

from rostether.bridge.findings.finding import Code, Severity, error, warning

PAGE = Path(__file__).parents[4] / "docs" / "how-to" / "when-a-board-does-not-connect.md"


def test_one_line_says_what_was_seen_and_what_to_do() -> None:
    finding = error(Code.BUSY, "the port is in use", "close the monitor")
    assert str(finding) == "the port is in use; close the monitor"
    assert finding.severity is Severity.ERROR
    assert warning(Code.BUSY, "", "").severity is Severity.WARN


def test_a_finding_stays_the_same_while_its_figures_change() -> None:
    first = warning(Code.FRAMES_DAMAGED, "1 % of the frames", "check the cable")
    second = warning(Code.FRAMES_DAMAGED, "2 % of the frames", "check the cable")
    assert first.key == second.key
    assert first.key != warning(Code.BUFFER_TOO_SMALL, "", "", "chatter").key


def test_every_finding_stands_in_the_documentation() -> None:
    listed = {line.split("`")[1] for line in PAGE.read_text().splitlines() if line.startswith("| `")}
    assert listed == {str(code) for code in Code}
