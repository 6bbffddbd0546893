from __future__ import annotations

import random

import pytest

from rostether.errors import ConfigError
from rostether.pictures.layered_layout import MAX_VERTICES, Layout, lay_out

SIZE = (80.0, 20.0)


def laid_out(edges: list[tuple[str, str]], *more: str) -> Layout:
    keys = dict.fromkeys([*(end for edge in edges for end in edge), *more])
    return lay_out(dict.fromkeys(keys, SIZE), edges)


def test_arrows_go_to_the_right() -> None:
    layout = laid_out([("a", "b"), ("b", "c"), ("a", "c")])
    xs = [layout.positions[key][0] for key in "abc"]
    assert xs == sorted(set(xs))
    for source, target in (("a", "b"), ("b", "c"), ("a", "c")):
        route = layout.routes[source, target]
        assert route[0] == (layout.positions[source][0] + SIZE[0] / 2, layout.positions[source][1])
        assert route[-1] == (layout.positions[target][0] - SIZE[0] / 2, layout.positions[target][1])
        assert [x for x, _ in route] == sorted(x for x, _ in route)


def test_a_cycle_has_an_arrow_back() -> None:
    layout = laid_out([("a", "b"), ("b", "c"), ("c", "a")])
    back = layout.routes["c", "a"]
    assert back[0][0] > back[-1][0]


def test_both_directions_are_shown_side_by_side() -> None:
    layout = laid_out([("a", "b"), ("b", "a")])
    there, back = layout.routes["a", "b"], layout.routes["b", "a"]
    assert {y for _, y in there}.isdisjoint(y for _, y in back)


def test_a_loop_has_no_route() -> None:
    assert laid_out([("a", "a")]).routes == {}


def test_crossings_are_undone() -> None:
    layout = laid_out([("a", "y"), ("b", "x"), ("a", "w"), ("c", "x")], "z")
    above = layout.positions["a"][1] < layout.positions["b"][1]
    assert above == (layout.positions["y"][1] < layout.positions["x"][1])


def test_a_source_is_left_of_its_first_target() -> None:
    layout = laid_out([("a", "b"), ("b", "c"), ("late", "c")])
    assert layout.positions["late"][0] == layout.positions["b"][0]


@pytest.mark.parametrize("seed", range(20))
def test_no_vertex_covers_another(seed: int) -> None:
    rng = random.Random(seed)
    keys = [f"v{number}" for number in range(rng.randint(2, 30))]
    edges = [(rng.choice(keys), rng.choice(keys)) for _ in range(rng.randint(0, 50))]
    sizes = {key: (rng.uniform(20, 200), rng.uniform(10, 40)) for key in keys}
    layout = lay_out(sizes, edges)
    boxes = [(*layout.positions[key], *sizes[key]) for key in keys]
    for number, (x1, y1, w1, h1) in enumerate(boxes):
        assert x1 - w1 / 2 >= -1e-6
        assert x1 + w1 / 2 <= layout.width + 1e-6
        assert y1 - h1 / 2 >= -1e-6
        assert y1 + h1 / 2 <= layout.height + 1e-6
        for x2, y2, w2, h2 in boxes[:number]:
            assert abs(x1 - x2) >= (w1 + w2) / 2 - 1e-6 or abs(y1 - y2) >= (h1 + h2) / 2 - 1e-6
    assert set(layout.routes) == {edge for edge in edges if edge[0] != edge[1]}


def test_the_same_graph_is_always_drawn_alike() -> None:
    edges = [("a", "b"), ("b", "c"), ("c", "a"), ("a", "d")]
    assert laid_out(edges) == laid_out(edges)


def test_too_many_vertices_are_refused() -> None:
    with pytest.raises(ConfigError, match="too large"):
        lay_out({str(number): SIZE for number in range(MAX_VERTICES + 1)}, [])


def test_an_empty_graph() -> None:
    assert lay_out({}, []) == Layout(0.0, 0.0, {}, {})


@pytest.mark.timeout(60)
def test_a_large_system_is_laid_out() -> None:
    """A fleet: robots with ten nodes each, chained by topics, and one node that listens to all."""
    edges = []
    for robot in range(30):
        for node in range(10):
            topic = f"/r{robot}/t{node}"
            edges += [(f"/r{robot}/n{node}", topic), (topic, f"/r{robot}/n{node + 1}"), (topic, "/watch")]
    layout = laid_out(edges)
    assert len(layout.positions) == 30 * 21 + 1


@pytest.mark.parametrize("seed", range(5))
def test_every_bend_is_inside_the_picture(seed: int) -> None:
    rng = random.Random(seed)
    nodes, topics = ([f"{kind}{number}" for number in range(count)] for kind, count in (("n", 20), ("t", 60)))
    edges = [(rng.choice(nodes), topic) for topic in topics]
    edges += [(topic, rng.choice(nodes)) for topic in topics for _ in range(3)]
    layout = lay_out(dict.fromkeys([*nodes, *topics], SIZE), edges)
    for points in layout.routes.values():
        assert all(0 <= x <= layout.width and 0 <= y <= layout.height for x, y in points)
