from __future__ import annotations

from rostether.mechanisms.line_budget import LineBudget


def test_lines_of_a_period_are_limited_and_counted() -> None:
    budget = LineBudget(2, 10.0)
    assert [budget.admit(100.0 + second) for second in range(5)] == [0, 0, None, None, None]
    assert budget.admit(110.0) == 3
    assert budget.admit(111.0) == 0
    assert budget.admit(112.0) is None
