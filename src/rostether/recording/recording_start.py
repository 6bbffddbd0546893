"""Checks at the start of a recording: whether the time is known, and the named topics are published."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Container

from rostether.errors import GraphError
from rostether.graph.ports import Graph
from rostether.mechanisms.text import unpublished_warning

# How often the first message on /clock is checked: simulations publish it at 100 Hz or more.
TIME_POLL_S = 0.01

# The time for a publisher of a named topic to connect: DDS takes more than a second on a busy machine.
CONNECT_S = 3.0


async def wait_for_time(graph: Graph, report: Callable[[str], None]) -> None:
    """Wait for simulated time: without a time, latched messages would be lost."""
    report("WARNING: use_sim_time is set: waiting for the first message on /clock")
    while not graph.now().to_ns():  # noqa: ASYNC110 - the port does not report it
        await asyncio.sleep(TIME_POLL_S)


async def report_missing(
    graph: Graph, names: Collection[str], connected: Container[str], report: Callable[[str], None]
) -> None:
    """Report the named topics that are not connected and have no publisher after `CONNECT_S`."""
    await asyncio.sleep(CONNECT_S)
    try:
        known = (await graph.snapshot()).topics
    except GraphError:
        return
    published = [topic.name for topic in known.values() if topic.publishers]
    for name in names:
        full = graph.resolve(name)
        if name not in connected and full not in published:
            report(unpublished_warning(full, published))
