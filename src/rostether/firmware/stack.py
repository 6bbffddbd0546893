"""Estimates how much stack a program can need: the deepest call path from `main` plus the deepest interrupt.

No function is entered twice on one path, directly or through pointers: recursion is reported, not followed.
Every call through a pointer counts all functions of its kind whose address is taken, so the estimate is more
likely too high than too low.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct

from rostether.firmware.call_graph import CallGraph
from rostether.firmware.elf import ElfFile

# About half a second of search. Only programs with many nested callbacks have more paths.
MAX_PATHS = 50_000

# One of the two kept callbacks may already be on the path; then the other is used.
_KEPT_PER_SHAPE = 2
# The node handle limits the recursion of its own functions.
_BOUNDED = "_ZN3ros"


class StackEstimate(Struct, frozen=True):
    """Stack bytes of `main` and of the deepest interrupt; the paths list the functions (not demangled).

    `unknown` lists reasons why the real stack could be larger.
    """

    main_bytes: int
    interrupt_bytes: int
    main_path: tuple[str, ...]
    interrupt_path: tuple[str, ...]
    unknown: tuple[str, ...]

    @property
    def total_bytes(self) -> int:
        """The deepest stack: an interrupt may occur at the deepest point of the program."""
        return self.main_bytes + self.interrupt_bytes


class _Path(Struct, frozen=True):
    depth_bytes: int
    entries: tuple[int, ...]


def estimate_stack(elf: ElfFile) -> StackEstimate:
    """Return the estimate for an AVR program."""
    graph = CallGraph(elf)
    search = _Search(graph)
    # main is called by the start-up code, an interrupt by the processor: both leave a return address.
    main = search.deepest(graph.entry_points)
    interrupt = search.deepest(graph.interrupts)
    return StackEstimate(
        main_bytes=main.depth_bytes,
        interrupt_bytes=interrupt.depth_bytes,
        main_path=tuple(graph.name(each) for each in main.entries),
        interrupt_path=tuple(graph.name(each) for each in interrupt.entries),
        unknown=tuple(_unknown(graph, elf))
        + (("not all call paths were followed",) if search.gave_up else ()),
    )


class _Search:
    """Finds the deepest path that enters no function twice.

    This restriction matters only for functions that can reach each other, so results are cached for each
    function with the functions of its own cycle above it.
    """

    def __init__(self, graph: CallGraph) -> None:
        self._graph = graph
        self._known: dict[tuple[int, frozenset[int]], _Path] = {}
        self._cycles: dict[int, frozenset[int]] = {}
        self._reachable: dict[int, frozenset[int]] = {}
        self._closed: dict[int, _Path] = {}
        self._open: dict[int, list[tuple[int, int]]] = {}
        self.gave_up = False

    def deepest(self, roots: Iterable[int]) -> _Path:
        """Return the deepest path from some functions; its depth is 0 if there are none."""
        paths = (self._path(root, frozenset()) for root in roots)
        best = max(paths, key=lambda path: path.depth_bytes, default=None)
        if best is None:
            return _Path(0, ())
        return _Path(best.depth_bytes + self._graph.return_bytes, best.entries)

    def _path(self, entry: int, above: frozenset[int]) -> _Path:
        key = (entry, above & self._cycle(entry))
        if key in self._known:
            return self._known[key]
        best = self._closed_path(entry)
        if len(self._known) > MAX_PATHS:
            self.gave_up = True
            return best
        above |= {entry}
        for target, depth in self._open_calls(entry):
            if target not in above:
                below = self._path(target, above)
                if depth + below.depth_bytes >= best.depth_bytes:
                    best = _Path(depth + below.depth_bytes, (entry, *below.entries))
        self._known[key] = best
        return best

    def _closed_path(self, entry: int) -> _Path:
        """Return the deepest path through functions in no cycle; it does not depend on the callers."""
        if entry not in self._closed:
            best = _Path(self._graph.walk(entry).depth_bytes, (entry,))
            for target, depth in self._graph.calls(entry).items():
                if not self._cycle(target):
                    below = self._path(target, frozenset())
                    if depth + below.depth_bytes >= best.depth_bytes:
                        best = _Path(depth + below.depth_bytes, (entry, *below.entries))
            self._closed[entry] = best
        return self._closed[entry]

    def _open_calls(self, entry: int) -> list[tuple[int, int]]:
        """Return the calls into cycles, without those that two other calls dominate.

        A sketch with many topics has many similar callbacks.
        """
        if entry not in self._open:
            calls = [
                (target, depth) for target, depth in self._graph.calls(entry).items() if self._cycle(target)
            ]
            # The deepest calls come first, so that they are kept among similar ones.
            calls.sort(key=lambda call: (-call[1], -self._closed_path(call[0]).depth_bytes, call[0]))
            kept: list[tuple[int, int]] = []
            for call in calls:
                if sum(self._dominates(each, call) for each in kept) < _KEPT_PER_SHAPE:
                    kept.append(call)
            self._open[entry] = kept
        return self._open[entry]

    def _dominates(self, one: tuple[int, int], other: tuple[int, int]) -> bool:
        (target, depth), (other_target, other_depth) = one, other
        if (
            depth + self._closed_path(target).depth_bytes
            < other_depth + self._closed_path(other_target).depth_bytes
        ):
            return False
        calls = self._graph.calls(target)
        return all(
            each in calls and depth + calls[each] >= other_depth + below
            for each, below in self._graph.calls(other_target).items()
            if self._cycle(each)
        )

    def _cycle(self, entry: int) -> frozenset[int]:
        """Return the functions that a function can reach, and that can reach it."""
        if entry not in self._cycles:
            self._cycles[entry] = frozenset(
                each for each in {entry, *self._below(entry)} if entry in self._below(each)
            )
        return self._cycles[entry]

    def _below(self, entry: int) -> frozenset[int]:
        if entry not in self._reachable:
            self._reachable[entry] = frozenset(self._graph.reachable(self._graph.calls(entry)))
        return self._reachable[entry]


def _unknown(graph: CallGraph, elf: ElfFile) -> list[str]:
    found = []
    for entry in graph.reachable([*graph.entry_points, *graph.interrupts]):
        here = graph.walk(entry)
        calls_itself = entry in graph.reachable(here.calls, through_pointers=False)
        if calls_itself and not graph.name(entry).startswith(_BOUNDED):
            found.append(f"{graph.name(entry)} calls itself")
        if here.is_unknown:
            found.append(f"{graph.name(entry)} needs an amount of stack that is computed at run time")
    if any(graph.walk(each).enables_interrupts for each in graph.reachable(graph.interrupts)):
        found.append("an interrupt handler enables interrupts")
    if any(each.name == "malloc" for each in elf.symbols):
        found.append("the heap (String, new, malloc) grows towards the stack")
    return found
