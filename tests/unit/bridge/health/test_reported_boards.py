from __future__ import annotations

from msgspec.structs import replace

from rostether.bridge.health.reported_boards import FORGET_S, MAX_BOARDS, STALE_S, SeenBoards
from unit.cli.bridge.test_monitor_table import ARM


class Clock:
    """A time that a test sets."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_a_board_that_falls_silent_disconnects_and_is_forgotten() -> None:
    clock = Clock()
    seen = SeenBoards(clock)
    seen.add_status(ARM)
    clock.now_s = 100.0 + STALE_S
    (board,) = seen.boards()
    assert board.state == "connected"
    clock.now_s = 100.5 + STALE_S
    (board,) = seen.boards()
    assert (board.state, board.level, board.connected_s) == ("gone", 2, None)
    assert "nothing on /diagnostics for" in board.findings[0]
    assert {each.rate_hz for each in board.endpoints} == {0.0}
    clock.now_s = 100.5 + FORGET_S
    assert seen.boards() == []


def test_kept_boards_are_limited() -> None:
    seen = SeenBoards(Clock())
    for number in range(MAX_BOARDS + 100):
        seen.add_status(replace(ARM, name=f"/board_{number}"))
    assert len(seen.boards()) == MAX_BOARDS


def test_rates_are_known_after_a_second_of_reports() -> None:
    clock = Clock()
    seen = SeenBoards(clock)
    for now_s, count in ((100.0, 0), (100.1, 0), (101.0, 1)):
        clock.now_s = now_s
        seen.add_status(ARM)
        assert seen.known_count() == count
