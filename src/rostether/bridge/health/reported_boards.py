"""The boards that running bridges report on /diagnostics."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import aclosing

from msgspec.structs import replace

from rostether.bridge.health.board_status import TOPIC, TYPE, BoardStatus, read_statuses
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.block_end import task_beside

# After two missing reports, the board or its bridge counts as disconnected.
STALE_S = 3.0

# How long a disconnected board stays in the table.
FORGET_S = 15.0

# The longest time that `reported_boards` listens: rates are known some time after a board's first report.
LISTEN_S = 6.0

# A bridge starts to measure rates with its first report to a new subscriber. The second report may follow
# immediately, before the rates are known.
RATES_AFTER_S = 0.9

# How long `reported_boards` waits for a publisher: a newly connected board advertises within a second.
NO_PUBLISHER_S = 2.5

# Any node may publish on /diagnostics; no user needs more boards than this.
MAX_BOARDS = 512

# Users do not notice this delay.
_POLL_S = 0.1


class SeenBoards:
    """The last status of each board, with the times of its first and last arrival by `clock`."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._seen: dict[str, tuple[float, float, BoardStatus]] = {}

    def add_status(self, status: BoardStatus) -> None:
        """Handle a status."""
        if status.name in self._seen or len(self._seen) < MAX_BOARDS:
            now_s = self._clock()
            first_s = self._seen[status.name][0] if status.name in self._seen else now_s
            self._seen[status.name] = first_s, now_s, status

    def boards(self) -> list[BoardStatus]:
        """Return the boards with their state; a silent one counts as disconnected, and is removed later."""
        now_s = self._clock()
        for name in [name for name, (_, at_s, _) in self._seen.items() if now_s - at_s > FORGET_S]:
            del self._seen[name]
        return [
            status if now_s - at_s <= STALE_S else _as_gone(status, now_s - at_s)
            for _, at_s, status in self._seen.values()
        ]

    def known_count(self) -> int:
        """Return how many boards have reported for long enough to know their rates."""
        return sum(at_s - first_s >= RATES_AFTER_S for first_s, at_s, _ in self._seen.values())


async def listen(graph: TypedGraph, on_status: Callable[[BoardStatus], object]) -> None:
    """Call `on_status` with each report of a board."""
    async with aclosing(aiter(graph.messages(TOPIC, TYPE, queue_size=2 * MAX_BOARDS))) as arrays:
        async for array in arrays:
            for status in read_statuses(array):
                on_status(status)


async def reported_boards(graph: TypedGraph) -> list[BoardStatus]:
    """Return the boards on a graph with their rates, by name."""
    loop = asyncio.get_running_loop()
    seen = SeenBoards(loop.time)
    began_s = loop.time()
    async with task_beside(listen(graph, seen.add_status)):
        while (waited_s := loop.time() - began_s) < LISTEN_S:
            await asyncio.sleep(_POLL_S)
            topic = (await graph.snapshot()).topics.get(TOPIC)
            expected = len(topic.publishers) if topic is not None else 0
            if expected and seen.known_count() >= expected:
                break
            if not expected and waited_s >= NO_PUBLISHER_S:
                break
    return sorted(seen.boards(), key=lambda board: board.name)


def _as_gone(status: BoardStatus, silence_s: float) -> BoardStatus:
    return replace(
        status,
        state="gone",
        level=2,
        connected_s=None,
        received_bytes_s=0.0,
        sent_bytes_s=0.0,
        endpoints=tuple(replace(each, rate_hz=0.0) for each in status.endpoints),
        findings=(
            f"nothing on {TOPIC} for {silence_s:.0f} s: the board was unplugged, or its bridge has stopped",
        ),
    )
