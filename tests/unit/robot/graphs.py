"""Nodes of a network in memory, and their messages."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import aclosing, asynccontextmanager

from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

TIMEOUT_S = 60.0


@asynccontextmanager
async def entered(network: MemoryNetwork, name: str) -> AsyncIterator[TypedGraph]:
    """Join a network in memory as a node."""
    graph = TypedGraph(await network.join(name), TypeStore(Registry()))
    try:
        yield graph
    finally:
        await graph.close()


async def first(
    graph: TypedGraph, topic: str, type_name: str, wanted: Callable[[Message], bool] = lambda _: True
) -> Message:
    """Return the first message of a topic for which `wanted` is true."""
    async with asyncio.timeout(TIMEOUT_S), aclosing(aiter(graph.messages(topic, type_name))) as messages:
        async for message in messages:
            if wanted(message):
                return message
    raise AssertionError("the node has left")
