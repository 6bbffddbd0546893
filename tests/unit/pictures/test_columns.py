from __future__ import annotations

import random
from itertools import pairwise

import pytest

from rostether.pictures.columns import MIN_COLUMNS, column_choices
from rostether.pictures.layered_layout import MAX_PAGE_WIDTH, MAX_RATIO, lay_out


def robot(nodes: int, topics: int, seed: int) -> tuple[list[str], list[tuple[str, str]]]:
    """Nodes and topics with one publisher and up to three subscribers each: a graph with many cycles."""
    rng = random.Random(seed)
    names = [f"/robot/node_{number}" for number in range(nodes)]
    edges = []
    for number in range(topics):
        topic = f"/robot/some_topic_{number}"
        edges.append((rng.choice(names), topic))
        edges += [(topic, each) for each in rng.sample(names, rng.randrange(min(nodes, 4)))]
    return [*names, *(f"/robot/some_topic_{number}" for number in range(topics))], edges


@pytest.mark.parametrize(
    "edges",
    [
        robot(6, 12, 1)[1],
        # A chain, a cycle, and a vertex with an edge over the next one.
        [(str(each), str(each + 1)) for each in range(9)],
        [("0", "1"), ("1", "2"), ("2", "0")],
        [("0", "1"), ("1", "2"), ("0", "2")],
    ],
)
def test_neighbors_never_share_a_column(edges: list[tuple[str, str]]) -> None:
    keys = list(dict.fromkeys(key for ends in edges for key in ends))
    choices = list(column_choices(keys, edges))
    assert choices
    for column in choices:
        assert set(column) == set(keys)
        assert all(column[source] != column[target] for source, target in edges)
        assert set(column.values()) == set(range(max(column.values()) + 1))
    widths = [max(column.values()) + 1 for column in choices[1:]]
    assert widths == sorted(widths, reverse=True)
    assert not widths or widths[-1] >= MIN_COLUMNS - 1


@pytest.mark.parametrize(("nodes", "topics"), [(5, 12), (20, 60), (60, 200)])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_robots_graph_fits_a_page_with_all_its_edges(nodes: int, topics: int, seed: int) -> None:
    keys, edges = robot(nodes, topics, seed)
    layout = lay_out(dict.fromkeys(keys, (160.0, 28.0)), edges)
    assert layout.width <= max(MAX_PAGE_WIDTH, MAX_RATIO * layout.height)
    assert set(layout.routes) == set(edges)
    points = [point for route in layout.routes.values() for point in route]
    assert all(0 <= x <= layout.width and 0 <= y <= layout.height for x, y in points)


def test_a_chain_that_is_too_wide_is_folded() -> None:
    keys = [str(each) for each in range(40)]
    edges = list(pairwise(keys))
    layout = lay_out(dict.fromkeys(keys, (100.0, 28.0)), edges)
    assert layout.width <= max(MAX_PAGE_WIDTH, MAX_RATIO * layout.height)
