from __future__ import annotations

import math

from rostether.pictures.axis import Axis
from rostether.pictures.plot import Curve
from rostether.pictures.terminal_plot import braille

UNIT = Axis(0.0, 1.0)


def lines(*curves: Curve, columns: int = 4, rows: int = 2) -> list[str]:
    cells = braille(curves, columns, rows, UNIT, UNIT)
    return ["".join(character for character, _ in row) for row in cells]


def test_a_rising_line() -> None:
    assert lines(Curve("a", [(0.0, 0.0), (1.0, 1.0)])) == ["  ⡠⠊", "⡠⠊  "]


def test_the_ends_of_the_ranges_are_at_the_edges() -> None:
    assert lines(Curve("a", [(0.0, 1.0)])) == ["⠁   ", "    "]
    assert lines(Curve("a", [(1.0, 0.0)])) == ["    ", "   ⢀"]


def test_gaps_stay_open() -> None:
    level = [(0.0, 0.0), (0.2, 0.0), (0.4, math.nan), (0.9, 0.0), (1.0, 0.0)]
    assert lines(Curve("a", level)) == ["    ", "⣀  ⣀"]


def test_the_last_curve_owns_a_shared_cell() -> None:
    cells = braille([Curve("a", [(0.0, 0.0), (1.0, 0.0)]), Curve("b", [(0.0, 0.0)])], 4, 2, UNIT, UNIT)
    assert [owner for _, owner in cells[1]] == [1, 0, 0, 0]
    assert [owner for _, owner in cells[0]] == [None] * 4


def test_points_far_outside_are_cut_off() -> None:
    assert lines(Curve("a", [(0.0, -1e300), (0.0, 1e300)]))[0][0] != " "
    assert lines(Curve("a", [(-9.0, 5.0), (-8.0, 5.0)])) == ["    ", "    "]
