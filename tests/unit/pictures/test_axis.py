from __future__ import annotations

import math
import time

import pytest

from rostether.pictures.axis import Axis, clock_ticks


@pytest.mark.parametrize(
    ("low", "high", "count", "texts"),
    [
        (0, 10, 5, ["0", "2", "4", "6", "8", "10"]),
        (-1, 1, 4, ["-1.0", "-0.5", "0.0", "0.5", "1.0"]),
        (0.001, 0.0042, 4, ["0.001", "0.002", "0.003", "0.004"]),
        (0, 3e6, 3, ["0", "1e+06", "2e+06", "3e+06"]),
        (99.97, 100.03, 3, ["99.98", "100.00", "100.02"]),
    ],
)
def test_marks_are_round_numbers(low: float, high: float, count: int, texts: list[str]) -> None:
    assert [text for _, text in Axis(low, high).ticks(count)] == texts


def test_values_have_a_margin() -> None:
    axis = Axis.around([0.0, math.nan, 10.0, math.inf])
    assert (axis.low, axis.high) == (-0.5, 10.5)
    assert axis.part(axis.low) == 0
    assert axis.part(axis.high) == 1
    assert axis.part(5.0) == pytest.approx(0.5)


@pytest.mark.parametrize(
    "values", [[], [3.0], [0.0, 5e-324], [-1.7e308, 1.7e308], [1e16, 1e16 + 2], [1.7e308], [math.nan]]
)
def test_every_range_can_be_drawn(values: list[float]) -> None:
    axis = Axis.around(values)
    assert axis.low < axis.high
    assert math.isfinite(axis.part(0.0))
    assert 0 < len(axis.ticks(6)) <= 50


def test_marks_of_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    time.tzset()
    try:
        # 12:00:07 in a time zone with half an hour.
        begin_s = 6 * 3600 + 30 * 60 + 7.0
        assert clock_ticks(Axis(0.0, 20.0), 4, begin_s) == [
            (3.0, "12:00:10"),
            (8.0, "12:00:15"),
            (13.0, "12:00:20"),
            (18.0, "12:00:25"),
        ]
        assert clock_ticks(Axis(0.0, 8000.0), 3, begin_s) == [(3593.0, "13:00:00"), (7193.0, "14:00:00")]
    finally:
        monkeypatch.undo()
        time.tzset()
