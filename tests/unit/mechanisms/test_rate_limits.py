from __future__ import annotations

from rostether.mechanisms.rate_limits import (
    MAX_KINDS,
    MAX_LINES,
    PERIOD_S,
    LineBudget,
    RepeatLimiter,
    TokenBucket,
)


def test_admits_a_burst_then_the_rate() -> None:
    bucket = TokenBucket(2.0, 10, 100.0)
    assert bucket.admit(4, 100.0) == 4
    assert bucket.admit(10, 100.0) == 6
    assert bucket.admit(10, 101.2) == 2
    assert bucket.admit(10, 101.5) == 1


def test_saves_no_more_than_a_burst() -> None:
    bucket = TokenBucket(2.0, 10, 100.0)
    assert bucket.room(1000.0) == 10
    assert bucket.admit(11, 1000.0) == 10
    assert bucket.room(1000.0) == 0


def test_lines_of_a_period_are_limited_and_counted() -> None:
    budget = LineBudget()
    assert [budget.admit(100.0) for _ in range(MAX_LINES + 3)] == [0] * MAX_LINES + [None] * 3
    assert budget.admit(100.0 + PERIOD_S) == 3
    assert [budget.admit(101.0 + PERIOD_S) for _ in range(MAX_LINES)] == [0] * (MAX_LINES - 1) + [None]


def test_one_line_in_each_period() -> None:
    lines = RepeatLimiter()
    assert [lines.admit("refused", 0.1 * number) for number in range(100)] == [0] + [None] * 99
    assert lines.admit("refused", PERIOD_S) == 99
    assert lines.admit("refused", PERIOD_S + 0.1, count=5) is None
    assert lines.admit("refused", 2 * PERIOD_S) == 5


def test_an_episode_lasts_until_it_was_quiet() -> None:
    lines = RepeatLimiter(by_episode=True)
    assert [lines.admit("noise", 9.0 * number) for number in range(10)] == [0] + [None] * 9
    assert lines.admit("noise", 81.0 + PERIOD_S) == 9


def test_kinds_are_independent_and_a_forgotten_one_is_admitted() -> None:
    lines = RepeatLimiter()
    assert [lines.admit(kind, 0.0) for kind in ("a", "b", "a", "b")] == [0, 0, None, None]
    lines.forget("a")
    lines.forget("never seen")
    assert [lines.admit(kind, 0.0) for kind in ("a", "b")] == [0, None]


def test_kinds_are_bounded() -> None:
    lines = RepeatLimiter()
    for number in range(MAX_KINDS + 1):
        lines.admit(f"kind {number}", 0.0)
    assert lines.admit(f"kind {MAX_KINDS}", 0.0) is None
    assert lines.admit("kind 0", 0.0) == 0
