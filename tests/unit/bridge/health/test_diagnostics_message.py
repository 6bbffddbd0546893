from __future__ import annotations

import pytest

from rostether.bridge.health.diagnostics_message import Rates


def test_growth_per_second() -> None:
    rates = Rates()
    assert rates.update({"a": 0}, 0.0) == {}
    assert rates.update({"a": 20}, 1.0) == {"a": 20.0}
    for second in range(2, 30):
        reported = rates.update({"a": 20 * second}, float(second))
    assert reported["a"] == pytest.approx(20.0)


def test_a_counter_that_is_new_or_began_again() -> None:
    rates = Rates()
    rates.update({"a": 1000}, 0.0)
    assert rates.update({"a": 10, "b": 5}, 1.0) == {"a": 10.0, "b": 5.0}


def test_a_board_that_stops_is_detected_within_seconds() -> None:
    rates = Rates()
    for second in range(10):
        rates.update({"a": 10 * second}, float(second))
    for second in range(10, 20):
        reported = rates.update({"a": 90}, float(second))
    assert reported["a"] == 0
