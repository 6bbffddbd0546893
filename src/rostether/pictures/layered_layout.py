"""Places the vertices of a directed graph in columns from left to right, with few crossings.

Sugiyama's method: every vertex gets a column (see `columns`), and edges over several columns get a bend in
each of them. Each column is ordered by the mean position of the neighbors, and each vertex is placed as near
to that mean as the sizes allow.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.pictures.columns import Ends, column_choices
from rostether.pictures.scene import Point

Size: TypeAlias = tuple[float, float]

# The time grows with the square of the number, and larger pictures are not readable.
MAX_VERTICES = 2_000

# A picture up to this width, or up to this ratio of width to height, fits a page or a screen.
MAX_PAGE_WIDTH = 1_500.0
MAX_RATIO = 2.0

_ROW_GAP = 16.0
_BEND_HEIGHT = 6.0

# Backward edges are drawn lower by this, to distinguish them from forward edges.
_REVERSED_SHIFT = 6.0
# More sweeps hardly change a picture.
_ORDERING_SWEEPS = 12
_PLACING_SWEEPS = 8


class Layout(Struct, frozen=True):
    """The centers of the vertices, and the points of each edge between the borders of its vertices."""

    width: float
    height: float
    positions: Mapping[str, Point]
    routes: Mapping[Ends, Sequence[Point]]


def lay_out(sizes: Mapping[str, Size], edges: Sequence[Ends], *, column_gap: float = 60.0) -> Layout:
    """Place vertices of these sizes, `column_gap` apart. Edges from a vertex to itself have no route.

    Raises ConfigError if there are too many vertices.
    """
    if len(sizes) > MAX_VERTICES:
        raise ConfigError(f"a graph of {len(sizes)} vertices is too large to draw; use --format dot")
    columns = _fitting(sizes, [ends for ends in dict.fromkeys(edges) if ends[0] != ends[1]], column_gap)
    columns.order()
    xs = columns.x_positions(column_gap)
    ys = columns.y_positions()
    positions = {key: (xs[key], ys[key]) for key in sizes}
    routes = {}
    for ends in dict.fromkeys(ends for ends in edges if ends[0] != ends[1]):
        is_reversed = ends not in columns.chains
        chain = columns.chains[ends[::-1] if is_reversed else ends]
        down = _REVERSED_SHIFT if is_reversed else 0.0
        points = [(xs[key], ys[key] + down) for key in chain]
        points[0] = (points[0][0] + sizes[chain[0]][0] / 2, points[0][1])
        points[-1] = (points[-1][0] - sizes[chain[-1]][0] / 2, points[-1][1])
        routes[ends] = points[::-1] if is_reversed else points
    right = max((xs[key] + size[0] / 2 for key, size in sizes.items()), default=0.0)
    # Bends of edges may be below all vertices.
    bottoms = [y for points in routes.values() for _, y in points]
    bottom = max((*bottoms, *(ys[key] + size[1] / 2 for key, size in sizes.items())), default=0.0)
    return Layout(right, bottom, positions, routes)


def _fitting(sizes: Mapping[str, Size], edges: Sequence[Ends], gap: float) -> _Columns:
    """Return the first choice of columns that fits a page, from wide to narrow."""
    for column in column_choices(list(sizes), edges):
        oriented = (ends if column[ends[0]] < column[ends[1]] else ends[::-1] for ends in edges)
        columns = _Columns(sizes, list(dict.fromkeys(oriented)), column)
        width, height = columns.extent(gap)
        if width <= max(MAX_PAGE_WIDTH, MAX_RATIO * height):
            break
    return columns


class _Columns:
    """Vertices and bends in columns; a bend's key differs from all keys of vertices."""

    def __init__(self, sizes: Mapping[str, Size], edges: Sequence[Ends], column: Mapping[str, int]) -> None:
        self._sizes = dict(sizes)
        self.chains: dict[Ends, list[str]] = {}
        self._before: dict[str, list[str]] = {key: [] for key in sizes}
        self._behind: dict[str, list[str]] = {key: [] for key in sizes}
        count = 1 + max(column.values(), default=0)
        self._columns: list[list[str]] = [[] for _ in range(count)]
        for key in sizes:
            self._columns[column[key]].append(key)
        for number, (source, target) in enumerate(edges):
            chain = [source]
            for index in range(column[source] + 1, column[target]):
                bend = f"\0{number} {index}"
                self._sizes[bend] = (0.0, _BEND_HEIGHT)
                self._before[bend], self._behind[bend] = [], []
                self._columns[index].append(bend)
                chain.append(bend)
            chain.append(target)
            self.chains[source, target] = chain
            for left, right in pairwise(chain):
                self._behind[left].append(right)
                self._before[right].append(left)

    def extent(self, gap: float) -> Size:
        """Return the width and the approximate height."""
        widths = (max((self._sizes[key][0] for key in keys), default=0.0) for keys in self._columns)
        heights = (sum(self._sizes[key][1] + _ROW_GAP for key in keys) for keys in self._columns)
        return sum(widths) + gap * (len(self._columns) - 1), max(heights, default=0.0)

    def order(self) -> None:
        """Order each column by the mean of its neighbors, in both directions; keep the best order."""
        best, fewest = [list(keys) for keys in self._columns], self._crossings()
        for sweep in range(_ORDERING_SWEEPS):
            is_forward = sweep % 2 == 0
            neighbors = self._before if is_forward else self._behind
            indexes = self._indexes()
            for keys in self._columns if is_forward else reversed(self._columns):
                self._sort(keys, neighbors, indexes)
            crossings = self._crossings()
            if crossings < fewest:
                best, fewest = [list(keys) for keys in self._columns], crossings
        self._columns = best

    @staticmethod
    def _sort(keys: list[str], neighbors: Mapping[str, list[str]], indexes: dict[str, int]) -> None:
        middles = {}
        for index, key in enumerate(keys):
            near = [indexes[each] for each in neighbors[key]]
            middles[key] = sum(near) / len(near) if near else float(index)
        keys.sort(key=lambda key: middles[key])
        indexes.update((key, index) for index, key in enumerate(keys))

    def _indexes(self) -> dict[str, int]:
        return {key: index for keys in self._columns for index, key in enumerate(keys)}

    def _crossings(self) -> int:
        indexes, count = self._indexes(), 0
        for keys in self._columns:
            targets: list[int] = []  # of the vertices above, ascending
            for key in keys:
                ends = [indexes[each] for each in self._behind[key]]
                count += sum(len(targets) - bisect_right(targets, end) for end in ends)
                for end in ends:
                    insort(targets, end)
        return count

    def x_positions(self, gap: float) -> dict[str, float]:
        xs, left = {}, 0.0
        for keys in self._columns:
            width = max((self._sizes[key][0] for key in keys), default=0.0)
            xs.update(dict.fromkeys(keys, left + width / 2))
            left += width + gap
        return xs

    def y_positions(self) -> dict[str, float]:
        """Return the y of each center; the top of the highest vertex is at 0."""
        ys = {}
        for keys in self._columns:
            ys.update(_spread(self._distances(keys), dict.fromkeys(keys, 0.0)))
        for sweep in range(_PLACING_SWEEPS):
            is_forward = sweep % 2 == 0
            for keys in self._columns if is_forward else reversed(self._columns):
                wanted = {key: self._middle(key, ys) for key in keys}
                ys.update(_spread(self._distances(keys), wanted))
        top = min((ys[key] - self._sizes[key][1] / 2 for key in ys), default=0.0)
        return {key: y - top for key, y in ys.items()}

    def _middle(self, key: str, ys: Mapping[str, float]) -> float:
        near = [ys[each] for each in (*self._before[key], *self._behind[key])]
        return sum(near) / len(near) if near else ys[key]

    def _distances(self, keys: Sequence[str]) -> list[tuple[str, float]]:
        """Return each key of a column with its minimum distance from the one above."""
        found = [(key, 0.0) for key in keys[:1]]
        for upper, lower in pairwise(keys):
            found.append((lower, (self._sizes[upper][1] + self._sizes[lower][1]) / 2 + _ROW_GAP))
        return found


def _spread(distances: Sequence[tuple[str, float]], wanted: Mapping[str, float]) -> dict[str, float]:
    """Return the positions nearest to the wanted ones (least squares) that keep order and distances.

    This is an isotonic regression after subtracting the distances: neighbors that would overlap form blocks.
    """
    shift, blocks = 0.0, []
    for key, distance in distances:
        shift += distance
        blocks.append((wanted[key] - shift, [(key, shift)]))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (upper, above), (lower, below) = blocks[-2:]
            mean = (upper * len(above) + lower * len(below)) / (len(above) + len(below))
            blocks[-2:] = [(mean, above + below)]
    return {key: level + offset for level, members in blocks for key, offset in members}
