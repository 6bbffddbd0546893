from __future__ import annotations

from math import inf, nan

from rostether.pictures.sparkline import sparkline


def test_sparkline_spans_its_values() -> None:
    assert sparkline([0, 1, 2, 3, 4, 5, 6, 7]) == "▁▂▃▄▅▆▇█"
    assert sparkline([2.0, 2.0]) == "▁▁"
    assert sparkline([]) == ""


def test_sparkline_has_a_scale_and_gaps() -> None:
    assert sparkline([1, 0, 1], (0, 1)) == "█▁█"
    assert sparkline([-5, 9], (0, 1)) == "▁█"
    assert sparkline([0, inf, nan, 1]) == "▁  █"
    assert sparkline([inf]) == " "
