from __future__ import annotations

from rostether.mechanisms.line_budget import MAX_LINES, PERIOD_S, LineBudget


def test_lines_of_a_period_are_limited_and_counted() -> None:
    budget = LineBudget()
    assert [budget.admit(100.0) for _ in range(MAX_LINES + 3)] == [0] * MAX_LINES + [None] * 3
    assert budget.admit(100.0 + PERIOD_S) == 3
    assert [budget.admit(101.0 + PERIOD_S) for _ in range(MAX_LINES)] == [0] * (MAX_LINES - 1) + [None]
