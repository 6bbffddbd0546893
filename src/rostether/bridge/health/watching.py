"""Bridges one board into a private graph for a while, to find its problems."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from msgspec import Struct

from rostether.bridge.board_node import BoardNode
from rostether.bridge.findings.finding import Code, Finding, error, split_step
from rostether.bridge.findings.line_watch import NO_ANSWER_S
from rostether.bridge.findings.noise import absence
from rostether.bridge.health.diagnostics import BoardView, EndpointView, view_board
from rostether.bridge.reporter import SilentReporter
from rostether.bridge.session import Session
from rostether.errors import TransportError
from rostether.graph.memory_network import MemoryNetwork
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.transports.address import SimulationPauses
from rostether.transports.transport import Transport

# This time includes three time requests, which show the speed of loop(), and enough frames for a percentage.
WATCH_S = 8.0

# How long to watch a board that was reset or whose time request was late: by then a pattern is visible.
UNSTABLE_WATCH_S = 20.0

# Users do not notice this delay.
_POLL_S = 0.1
# As often as a bridge checks its boards.
_FIND_PERIOD_S = 1.0
_NODE = "/board"


class BoardObservations(Struct, frozen=True):
    """The observations of one board, which was watched for `watched_s`."""

    findings: tuple[Finding, ...]
    view: BoardView
    watched_s: float
    clock_offset_s: float | None
    clock_drift_ppm: float | None

    def rate_hz(self, endpoint: EndpointView) -> float:
        """Return how many messages of an endpoint of `view` arrived per second."""
        return endpoint.message_count / max(self.watched_s, _POLL_S)


async def watch_board(
    transport: Transport,
    baud: int | None,
    store: TypeStore,
    *,
    watch_s: float,
    pauses: SimulationPauses | None = None,
) -> BoardObservations:
    """Serve a board for `watch_s` after its first answer, or until none can be expected; then close it."""
    clock = asyncio.get_running_loop().time
    # A step of the wall clock would look like drift of the board's clock.
    epoch_ns = time.time_ns() - round(clock() * 1e9)
    graph = await MemoryNetwork(lambda: Time.from_ns(epoch_ns + round(clock() * 1e9))).join(_NODE)
    node = BoardNode(graph, store, SilentReporter(), clock)
    session = Session(transport, node, baud=baud)
    if pauses is not None:
        pauses.on_pause = session.note_pause
    began_s = clock()
    session.start()
    try:
        alive_s = await _watch(session, clock, watch_s)
        now_s = clock()
        watched_s = now_s - (alive_s if alive_s is not None else began_s)
        findings = node.health.find(now_s)
        if not session.is_connected:
            findings.insert(0, _lost(await session.wait_ended()))
        elif alive_s is None and not findings:
            findings.append(absence(session.watch.noise, baud, watched_s))
        view = view_board(node, session)
        estimate = node.health.clock
        return BoardObservations(
            tuple(findings),
            view,
            watched_s,
            estimate.offset_s(view.round_trip_s),
            estimate.drift_ppm,
        )
    finally:
        await session.stop()
        await node.close()


async def _watch(session: Session, clock: Callable[[], float], watch_s: float) -> float | None:
    """Watch the board for `watch_s`, longer if it may be unstable; return when it first answered."""
    began_s = found_s = clock()
    alive_s: float | None = None
    while session.is_connected:
        await asyncio.sleep(_POLL_S)
        now_s = clock()
        if now_s - found_s >= _FIND_PERIOD_S:
            # Findings compare the counts of two checks.
            found_s = now_s
            session.node.health.find(now_s)
        if session.watch.was_alive:
            alive_s = now_s if alive_s is None else alive_s
            is_unstable = session.link.statistics.resets > 0 or session.watch.loop_speed.is_suspect
            # On a slow machine, the search for the types of the topics may take longer than the watch.
            wanted_s = max(UNSTABLE_WATCH_S, watch_s) if is_unstable or session.is_searching else watch_s
            if now_s - alive_s >= wanted_s:
                break
        elif now_s - began_s >= NO_ANSWER_S:
            break
    return alive_s


def _lost(failure: TransportError | None) -> Finding:
    text = str(failure or "the board closed the connection")
    seen, step = split_step(text, "check for a loose plug and a weak power supply")
    return error(Code.CONNECTION_LOST, f"the connection ended: {seen}", step)
