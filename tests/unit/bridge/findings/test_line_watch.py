from __future__ import annotations

from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.line_watch import LineWatch
from rostether.bridge.findings.resets import Resets
from rostether.rosserial.events import TimeRequested
from rostether.rosserial.link_statistics import LinkStatistics


def codes(checked_s: set[int]) -> set[Code]:
    watch = LineWatch(None, Resets(), LinkStatistics(), 0.0)
    found: set[Code] = set()
    for second in range(20):
        if second in checked_s:
            found |= {each.code for each in watch.find(float(second))}
        if second in (4, 7, 16):
            watch.handle_event(TimeRequested(), float(second))
    return found


def test_requests_that_waited_while_this_process_was_paused_are_not_late() -> None:
    running, paused = set(range(20)), set(range(8, 16))
    assert Code.SLOW_LOOP in codes(running)
    assert Code.SLOW_LOOP not in codes(running - paused)
