"""The node of client/extras/tests/platforms, the bridge, and a program in the same graph."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from waiting import until

STORE = TypeStore(Registry())
# Longer than any silence of a working node, even on a busy machine.
TIMEOUT_S = 60.0


class NodeHarness:
    """A graph in memory with a bridge and a program that uses the node."""

    def __init__(self, network: MemoryNetwork, graph: TypedGraph) -> None:
        self.network = network
        self.graph = graph
        self.reporter = RecordingReporter()
        self.counts: list[int] = []
        self.answers: list[str] = []

    @contextlib.asynccontextmanager
    async def bridge(self, address: str) -> AsyncIterator[list[str]]:
        """Serve an address; yield the addresses of the listeners, with their ports."""
        # The graph must show immediately that a board has left.
        settings = BridgeSettings(grace_s=0.0)
        supervisor = Supervisor(self.network.join, STORE, reporter=self.reporter, settings=settings)
        await supervisor.start([parse_address(address)])
        try:
            yield supervisor.listening_on
        finally:
            await supervisor.close()

    async def wait_for_counts(self, more: int = 3) -> None:
        """Wait until the node has published `more` messages."""
        before = len(self.counts)
        await until(lambda: len(self.counts) >= before + more, "the node's counter")

    async def ask(self, question: str) -> str:
        """Send a question to the node, and return its answer."""
        publisher = await self.graph.publisher("/question", "std_msgs/String")
        try:
            assert await publisher.wait_for_subscriber(TIMEOUT_S), "the node does not subscribe"
            before = len(self.answers)
            publisher.publish(data=question)
            await until(lambda: len(self.answers) > before, f"an answer to {question[:40]!r}")
            return self.answers[before]
        finally:
            await publisher.close()

    async def exchange_messages(self) -> None:
        """Use all topics, services and parameters of the node."""
        await self.wait_for_counts()
        assert await self.ask("hello") == "hello"
        long = "".join(chr(32 + n % 95) for n in range(450))
        assert await self.ask(long) == long
        await self.graph.set_param("/greeting", "good morning")
        assert await self.ask("parameter") == "good morning"
        assert await self.ask("service") == "pulled"
        for data, reported in ((True, "on"), (False, "off")):
            response = await self.graph.call("/switch", "std_srvs/SetBool", {"data": data})
            assert (response.success, response.message) == (data, reported)
        assert self.reporter.having("here I am"), self.reporter.texts


@contextlib.asynccontextmanager
async def node_harness() -> AsyncIterator[NodeHarness]:
    """Open a graph with a program that subscribes to the node's topics and offers the service that the node
    calls.
    """
    network = MemoryNetwork()
    graph = TypedGraph(await network.join("program"), STORE)
    harness = NodeHarness(network, graph)

    def pull(_request: Message) -> dict[str, Any]:
        return {"success": True, "message": "pulled"}

    async def collect_counts() -> None:
        async for message in graph.messages("/count", "std_msgs/UInt32"):
            harness.counts.append(message.data)

    async def collect_answers() -> None:
        async for message in graph.messages("/answer", "std_msgs/String"):
            harness.answers.append(message.data)

    await graph.service_server("/trigger", "std_srvs/Trigger", pull)
    tasks = [asyncio.ensure_future(collect_counts()), asyncio.ensure_future(collect_answers())]
    try:
        yield harness
    except AssertionError as error:
        error.add_note("\n".join(["the bridge reported:", *harness.reporter.texts[-10:]]))
        raise
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await graph.close()
