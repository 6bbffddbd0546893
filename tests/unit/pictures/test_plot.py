from __future__ import annotations

import math

from rostether.pictures.plot import COLORS, Curve, draw_plot, pieces
from rostether.pictures.scene import Line, Point, Scene, Text


def drawn(scene: Scene, number: int) -> list[Line]:
    """Return a curve's lines, without the one in the legend."""
    return [item for item in scene.items if isinstance(item, Line) and item.color == COLORS[number]][1:]


def test_curves_share_axes_and_have_names() -> None:
    rising: list[Point] = [(0.0, 0.0), (10.0, 1.0)]
    scene = draw_plot([Curve("/a/x", rising), Curve("/a/y", [(0.0, 1.0), (10.0, 1.0)])])
    (up,), (level,) = drawn(scene, 0), drawn(scene, 1)
    assert up.points[0][0] == level.points[0][0]
    assert up.points[-1] == level.points[-1]
    assert up.points[0][1] > up.points[-1][1]
    texts = [item.text for item in scene.items if isinstance(item, Text)]
    assert {"/a/x", "/a/y", "seconds", "0.0", "1.0", "2"} <= set(texts)


def test_everything_is_inside_the_picture() -> None:
    points = [(step / 10, 1000 * math.sin(step / 7)) for step in range(300)]
    scene = draw_plot([Curve("a", points)])
    for item in scene.items:
        places = item.points if isinstance(item, Line) else ((item.x, item.y),)
        assert all(0 <= x <= scene.width and 0 <= y <= scene.height for x, y in places)


def test_a_flood_of_points_keeps_its_extremes() -> None:
    points = [(step / 1e4, 0.0) for step in range(100_000)]
    points[33_333] = (3.3333, 5.0)
    (line,) = drawn(draw_plot([Curve("a", points)]), 0)
    assert len(line.points) < 4_000
    assert min(y for _, y in line.points) < 100


def test_gaps_divide_a_curve() -> None:
    values = [1.0, math.nan, math.inf, 2.0, 3.0, math.nan]
    points = [(float(step), value) for step, value in enumerate(values)]
    assert list(pieces(points)) == [[(0.0, 1.0)], [(3.0, 2.0), (4.0, 3.0)]]
    assert len(drawn(draw_plot([Curve("a", points)]), 0)) == 2


def test_a_plot_without_curves_is_a_frame() -> None:
    scene = draw_plot([])
    assert (scene.width, len(scene.items) > 5) == (900, True)
