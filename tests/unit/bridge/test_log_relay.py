from __future__ import annotations

import pytest

from rostether.bridge.log_relay import relay_log
from rostether.bridge.reporter import Notices
from rostether.graph.ports import Level
from rostether.rosserial.packets import LogLevel
from unit.bridge.doubles import RecordingReporter


@pytest.mark.parametrize("level", list(LogLevel))
def test_levels_keep_their_names(level: LogLevel) -> None:
    reporter = RecordingReporter()
    relay_log(level, "text", Notices(reporter, "/board", lambda: 0.0))
    assert reporter.lines == [(Level[level.name], "text", "/board")]


def test_the_graph_gets_the_text_as_it_is_and_people_one_line() -> None:
    reporter = RecordingReporter()
    logged: list[str] = []
    notices = Notices(reporter, "/board", lambda: 0.0)
    notices.to_graph = lambda _, text: logged.append(text)
    relay_log(LogLevel.INFO, "two\nlines\r\n", notices)
    assert logged == ["two\nlines\r\n"]
    assert reporter.texts == ["two\\nlines"]
