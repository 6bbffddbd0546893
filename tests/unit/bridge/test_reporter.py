from __future__ import annotations

import logging

import pytest

from rostether.bridge.reporter import (
    MAX_LINE_CHARS,
    LimitedReporter,
    Notices,
    SilentReporter,
    shown_line,
)
from rostether.graph.ports import Level
from rostether.mechanisms.rate_limits import PERIOD_S
from unit.bridge.doubles import RecordingReporter


class Clock:
    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def reporter() -> RecordingReporter:
    return RecordingReporter()


@pytest.fixture
def notices(reporter: RecordingReporter, clock: Clock) -> Notices:
    return Notices(reporter, "/board", clock)


def test_a_line_names_its_node_and_goes_to_the_graph(notices: Notices, reporter: RecordingReporter) -> None:
    logged: list[tuple[Level, str]] = []
    notices.to_graph = lambda level, text: logged.append((level, text))
    notices.report(Level.INFO, "Setup publisher on chatter [std_msgs/String]")
    assert reporter.lines == [(Level.INFO, "Setup publisher on chatter [std_msgs/String]", "/board")]
    assert logged == [(Level.INFO, "Setup publisher on chatter [std_msgs/String]")]


def test_an_episode_is_one_line(notices: Notices, reporter: RecordingReporter, clock: Clock) -> None:
    for _ in range(1000):
        clock.now_s += PERIOD_S / 2
        notices.report_episode("misfit", Level.WARN, "damaged")
    assert reporter.texts == ["damaged"]


def test_a_new_episode_reports_what_the_last_one_omitted(
    notices: Notices, reporter: RecordingReporter, clock: Clock
) -> None:
    notices.report_episode("misfit", Level.WARN, "damaged")
    notices.report_episode("misfit", Level.WARN, "damaged", count=41)
    clock.now_s = PERIOD_S + 1
    notices.report_episode("misfit", Level.WARN, "damaged")
    assert reporter.texts == ["damaged", "damaged (41 more since the last such line)"]


def test_an_ended_episode_is_reported_again(notices: Notices, reporter: RecordingReporter) -> None:
    notices.report_episode("silent", Level.WARN, "silent")
    notices.end_episode("silent")
    notices.report_episode("silent", Level.WARN, "silent")
    assert reporter.texts == ["silent", "silent"]


def test_a_text_is_made_only_when_it_is_reported(notices: Notices) -> None:
    made: list[int] = []

    def make() -> str:
        made.append(1)
        return "text"

    notices.report_episode("kind", Level.WARN, make)
    notices.report_episode("kind", Level.WARN, make)
    assert made == [1]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain\r\n", "plain"),
        ("\x1b[2Jgone", "\\u001b[2Jgone"),
        ("two\nlines", "two\\nlines"),
        ("grün", "grün"),
        ("x" * 600, "x" * (MAX_LINE_CHARS - 3) + "..."),
    ],
)
def test_a_peers_text_cannot_control_a_terminal(text: str, shown: str) -> None:
    assert shown_line(text) == shown


def test_remote_peers_cause_few_lines(reporter: RecordingReporter, clock: Clock) -> None:
    limited = LimitedReporter(reporter, clock)
    for number in range(100):
        limited.report(Level.INFO, f"connection {number}")
    assert reporter.texts == [f"connection {number}" for number in range(20)]
    clock.now_s = 10.0
    limited.report(Level.INFO, "connection 100")
    assert reporter.texts[20:] == ["omitted 80 lines like the next one", "connection 100"]


def test_silence(capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG):
        SilentReporter().report(Level.FATAL, "nothing shows", node="/arm")
    assert capfd.readouterr() == ("", "")
    assert not caplog.records


def test_the_graph_gets_the_whole_text_and_users_one_line() -> None:
    reporter = RecordingReporter()
    logged: list[str] = []
    notices = Notices(reporter, "/board", lambda: 0.0)
    notices.to_graph = lambda _, text: logged.append(text)
    notices.report(Level.INFO, "two\nlines\r\n")
    assert logged == ["two\nlines\r\n"]
    assert reporter.texts == ["two\\nlines"]
