"""Two graphs in memory with a relay between them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from contract.graphs import ADD_DIAGNOSTICS, EMPTY, SET_BOOL
from rostether.errors import UnknownTypeError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Level
from rostether.msgdef.interface import ServiceType
from rostether.relay.relay import Relay
from rostether.relay.relay_filter import RelayFilter, ServiceFilter, TopicFilter
from rostether.relay.side import ForgetNode, RelaySide

SERVICE_TYPES = {each.name: each for each in (SET_BOOL, ADD_DIAGNOSTICS, EMPTY)}


async def service_type(service: str, name: str) -> ServiceType:
    if name not in SERVICE_TYPES:
        raise UnknownTypeError(f"no definition of {name}, the type of {service}")
    return SERVICE_TYPES[name]


class World:
    """Two graphs with a node in each, and the lines that the relay reports."""

    def __init__(self) -> None:
        self.networks = MemoryNetwork(), MemoryNetwork()
        self.lines: list[str] = []

    async def join(self) -> None:
        self.one, self.two = [await network.join("/node") for network in self.networks]
        self.relays = [await network.join("/relay") for network in self.networks]

    def carries(self, name: str, graph: int) -> bool:
        topic = self.networks[graph].snapshot().topics.get(name)
        return topic is not None and "/relay" in topic.publishers

    @property
    def relayed(self) -> set[str]:
        """The items that the relay reports as relayed and not yet as ended."""
        relayed: set[str] = set()
        for line in self.lines:
            if line.startswith("no longer relaying "):
                relayed.discard(line.removeprefix("no longer relaying "))
            elif line.startswith("relaying "):
                relayed.add(line.removeprefix("relaying ").partition(" (")[0])
        return relayed

    @asynccontextmanager
    async def relaying(
        self,
        *topics: TopicFilter,
        services: tuple[ServiceFilter, ...] = (),
        forget_if_gone: ForgetNode | None = None,
    ) -> AsyncIterator[None]:
        sides = [
            RelaySide("one", self.relays[0], service_type, forget_if_gone),
            RelaySide("two", self.relays[1], service_type),
        ]

        def report(_: Level, line: str) -> None:
            self.lines.append(line)

        relay = Relay(sides[0], sides[1], RelayFilter(topics, services), report)
        running = asyncio.ensure_future(relay.run())
        try:
            yield
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            assert not self.relayed
