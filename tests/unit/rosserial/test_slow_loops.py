"""A sketch that sleeps in its loop() does not count as reset, and a real reset is detected."""

from __future__ import annotations

import pytest

from effort import effort
from unit.rosserial.slow_loop import Library, SlowLoop, meet, resets_of

pytestmark = pytest.mark.slow

BOOTED_S = effort([-0.5, 0.06, 0.62, 1.18, 2.1], [-0.5, -0.22, 0.06, 0.34, 0.62, 0.9, 1.18, 1.46, 2.1])


@pytest.mark.parametrize("library", Library)
@pytest.mark.parametrize("loop_s", [0.01, 0.2, 0.5, 1.0, 1.5, 2.0])
def test_a_late_answer_is_not_a_reset(library: Library, loop_s: float) -> None:
    for booted_s in BOOTED_S:
        events = meet(SlowLoop(library, loop_s, booted_s), 25.0)
        assert resets_of(events) == [], booted_s


@pytest.mark.parametrize("library", [Library.ONE_PER_SPIN, Library.EACH_AT_ONCE, Library.ONCE_FOR_ALL])
@pytest.mark.parametrize("loop_s", [0.01, 0.2, 1.0, 2.0])
def test_an_introduction_after_a_reset_is_detected_immediately(library: Library, loop_s: float) -> None:
    for booted_s in BOOTED_S:
        # Later than the first negotiation, in which there is nothing to lose yet.
        for after_s in (7.45, 8.3, 11.15, 17.4):
            reset_s = max(booted_s, 0.0) + after_s
            events = meet(SlowLoop(library, loop_s, booted_s), reset_s + 10.0, [reset_s])
            assert resets_of(events) == [pytest.approx(reset_s)], (booted_s, reset_s)


@pytest.mark.parametrize("loop_s", [0.01, 0.2])
def test_an_established_board_that_was_reset_is_seen_within_two_seconds(loop_s: float) -> None:
    for booted_s in BOOTED_S:
        for after_s in (1.3, 2.9, 4.2, 5.5, 7.1, 11.0):
            reset_s = max(booted_s, 0.0) + 3.0 + after_s
            events = meet(SlowLoop(Library.ESTABLISHED, loop_s, booted_s), reset_s + 10.0, [reset_s])
            assert len(found := resets_of(events)) == 1, (booted_s, reset_s)
            assert reset_s < found[0] < reset_s + 2.0


def test_two_resets_on_end_are_both_seen() -> None:
    events = meet(SlowLoop(Library.ONE_PER_SPIN, 1.0), 30.0, [10.3, 12.9])
    assert resets_of(events) == [pytest.approx(10.3), pytest.approx(12.9)]


@pytest.mark.parametrize("library", [Library.ONCE_FOR_ALL, Library.ESTABLISHED])
@pytest.mark.parametrize("loop_s", [0.01, 0.2, 0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("setup_s", [0.0, 3.0])
def test_the_first_message_finds_room_in_the_uart(library: Library, loop_s: float, setup_s: float) -> None:
    for booted_s in BOOTED_S:
        board = SlowLoop(library, loop_s, booted_s)
        board.spin_s += setup_s
        events = meet(board, 30.0, message=b"latched")
        assert board.received == [b"latched"], booted_s
        assert resets_of(events) == []
