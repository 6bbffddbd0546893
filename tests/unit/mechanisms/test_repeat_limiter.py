from __future__ import annotations

from rostether.mechanisms.repeat_limiter import MAX_KINDS, PERIOD_S, RepeatLimiter


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
