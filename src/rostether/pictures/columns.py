"""Chooses the column of each vertex of a directed graph that is drawn from left to right.

An edge never connects two vertices of one column. Edges to a column on the left are drawn backwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from graphlib import TopologicalSorter
from itertools import count
from typing import Final, TypeAlias

Ends: TypeAlias = tuple[str, str]

# With fewer columns, the picture is only a list.
MIN_COLUMNS: Final = 3


def column_choices(keys: Sequence[str], edges: Sequence[Ends]) -> Iterator[dict[str, int]]:
    """Yield columns by vertex, from wide to narrow.

    In the first choice, every vertex is to the right of its farthest source; edges that close a cycle are
    reversed. In the second, it is to the right of its nearest source. Each further choice folds these into
    one column fewer.
    """
    yield _longest_paths(keys, _without_cycles(keys, edges))
    depths = _shortest_paths(keys, edges)
    neighbors: dict[str, list[str]] = {key: [] for key in keys}
    for source, target in edges:
        neighbors[source].append(target)
        neighbors[target].append(source)
    for width in range(max(depths.values(), default=0) + 1, MIN_COLUMNS - 1, -1):
        yield _separated({key: _folded(depth, width) for key, depth in depths.items()}, neighbors)


def _folded(depth: int, width: int) -> int:
    """Return the column of a depth: 0 1 2 1 0 1 2 for three columns. Neighbors stay neighbors."""
    step = depth % (2 * width - 2)
    return min(step, 2 * width - 2 - step)


def _separated(wanted: Mapping[str, int], neighbors: Mapping[str, Sequence[str]]) -> dict[str, int]:
    """Return the columns nearest to the wanted ones that separate all neighbors, without empty columns."""
    placed: dict[str, int] = {}
    for key in sorted(wanted, key=lambda each: wanted[each]):
        taken = {placed[each] for each in neighbors[key] if each in placed}
        tried = (wanted[key] + offset for step in count() for offset in (step, -step))
        placed[key] = next(each for each in tried if each >= 0 and each not in taken)
    numbers = {column: number for number, column in enumerate(sorted(set(placed.values())))}
    return {key: numbers[column] for key, column in placed.items()}


def _adjacency(keys: Sequence[str], edges: Sequence[Ends]) -> tuple[dict[str, list[str]], dict[str, int]]:
    """Return the targets of the edges of each vertex, and the number of edges to it."""
    following: dict[str, list[str]] = {key: [] for key in keys}
    entered = dict.fromkeys(keys, 0)
    for source, target in edges:
        following[source].append(target)
        entered[target] += 1
    return following, entered


def _shortest_paths(keys: Sequence[str], edges: Sequence[Ends]) -> dict[str, int]:
    """Return the number of edges to each vertex from the nearest one without predecessors.

    A cycle without such a vertex starts at its first vertex.
    """
    following, entered = _adjacency(keys, edges)
    depths: dict[str, int] = {}
    starts = [[key for key in keys if not entered[key]], *([key] for key in keys)]
    for start in starts:
        ready = [key for key in start if key not in depths]
        depths.update(dict.fromkeys(ready, 0))
        for key in ready:
            for target in following[key]:
                if target not in depths:
                    depths[target] = depths[key] + 1
                    ready.append(target)
    return depths


def _without_cycles(keys: Sequence[str], edges: Sequence[Ends]) -> list[Ends]:
    """Return the edges; those that lead back in a depth-first search are reversed."""
    following, entered = _adjacency(keys, edges)
    reversed_edges: set[Ends] = set()
    done: set[str] = set()
    # Start at vertices without incoming edges, so that only edges of true cycles are reversed.
    for start in sorted(keys, key=lambda key: entered[key] > 0):
        if start in done:
            continue
        on_path = {start}
        walk = [(start, iter(following[start]))]
        while walk:
            key, rest = walk[-1]
            step = next(rest, None)
            if step is None:
                walk.pop()
                on_path.discard(key)
                done.add(key)
            elif step in on_path:
                reversed_edges.add((key, step))
            elif step not in done:
                on_path.add(step)
                walk.append((step, iter(following[step])))
    oriented = (ends[::-1] if ends in reversed_edges else ends for ends in edges)
    return list(dict.fromkeys(oriented))


def _longest_paths(keys: Sequence[str], edges: Sequence[Ends]) -> dict[str, int]:
    """Return each vertex's column: after all its predecessors; without any, just before its first target."""
    following, entered = _adjacency(keys, edges)
    column, sorter = dict.fromkeys(keys, 0), TopologicalSorter[str]()
    for source, target in edges:
        sorter.add(target, source)
    for key in sorter.static_order():
        for target in following[key]:
            column[target] = max(column[target], column[key] + 1)
    for key, targets in following.items():
        if targets and not entered[key]:
            column[key] = min(column[target] for target in targets) - 1
    return column
