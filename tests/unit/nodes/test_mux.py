from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from contract.graphs import STRING, Inbox, string
from rostether.errors import ServiceCallError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Publisher
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.nodes.mux import Mux
from rostether.serde.store import TypeStore
from waiting import until

STORE = TypeStore(Registry())


class World:
    def __init__(self) -> None:
        self.network = MemoryNetwork()

    async def join(self) -> World:
        nodes = [await self.network.join(name) for name in ("/talker", "/mux_node", "/listener")]
        self.talker, self.node, self.listener = [TypedGraph(each, STORE) for each in nodes]
        self.inputs: dict[str, Publisher] = {
            name: await self.talker.raw.advertise(name, STRING) for name in ("/a", "/b")
        }
        return self

    @asynccontextmanager
    async def muxing(
        self, *inputs: str, initial: str = "", lazy: bool = False, latch: bool = False
    ) -> AsyncIterator[Inbox]:
        mux = Mux(self.node, "/out", inputs, initial=initial, lazy=lazy, latch=latch)
        running = asyncio.ensure_future(mux.run())
        inbox = Inbox()
        await self.listener.raw.subscribe("/out", STRING, inbox.store)
        await until(lambda: "/mux/list" in self.network.snapshot().services)
        await until(lambda: "/mux_node" in self.network.snapshot().topics["/out"].publishers)
        try:
            yield inbox
        finally:
            running.cancel()
            await asyncio.wait([running])

    async def call(self, service: str, kind: str, **request: str) -> dict[str, object]:
        answer = await self.listener.call(service, f"topic_tools/{kind}", request, timeout_s=60)
        fields: tuple[str, ...] = ("prev_topic", "topics")
        return {each: getattr(answer, each) for each in fields if hasattr(answer, each)}

    async def selected(self) -> object:
        return (await self.listener.wait_for_message("/mux/selected", timeout_s=60)).data


@pytest.fixture
async def world() -> World:
    return await World().join()


async def test_the_first_input_is_published_until_another_is_selected(world: World) -> None:
    async with world.muxing("a", "/b") as inbox:
        await until(lambda: all(each.subscriber_count for each in world.inputs.values()))
        world.inputs["/b"].publish_raw([string("not this")])
        world.inputs["/a"].publish_raw([string("one")])
        await until(lambda: inbox.payloads == [string("one")])
        assert await world.selected() == "/a"
        assert await world.call("/mux/select", "MuxSelect", topic="b") == {"prev_topic": "/a"}
        world.inputs["/a"].publish_raw([string("not this")])
        world.inputs["/b"].publish_raw([string("two")])
        await until(lambda: inbox.payloads == [string("one"), string("two")])
        assert await world.selected() == "b"
        assert await world.call("/out_select", "MuxSelect", topic="__none") == {"prev_topic": "/b"}
        assert await world.call("/mux/select", "MuxSelect", topic="/a") == {"prev_topic": ""}


async def test_inputs_can_be_added_and_deleted(world: World) -> None:
    async with world.muxing("/a"):
        assert await world.call("/mux/list", "MuxList") == {"topics": ["/a"]}
        await world.call("/mux/add", "MuxAdd", topic="b")
        assert await world.call("/mux/list", "MuxList") == {"topics": ["/a", "/b"]}
        await until(lambda: world.inputs["/b"].subscriber_count == 1)
        await world.call("/mux/delete", "MuxDelete", topic="/b")
        await until(lambda: world.inputs["/b"].subscriber_count == 0)


@pytest.mark.parametrize(
    ("service", "kind", "topic", "reason"),
    [
        ("select", "MuxSelect", "/c", "is not an input; the inputs are /a"),
        ("add", "MuxAdd", "/a", "is already an input"),
        ("add", "MuxAdd", "__none", "means no input;"),
        ("add", "MuxAdd", "not a name", "is not a ROS name"),
        ("delete", "MuxDelete", "/a", "is selected"),
        ("delete", "MuxDelete", "/c", "is not an input"),
    ],
)
async def test_invalid_requests_fail(world: World, service: str, kind: str, topic: str, reason: str) -> None:
    async with world.muxing("/a"):
        with pytest.raises(ServiceCallError, match=reason):
            await world.call(f"/mux/{service}", kind, topic=topic)


@pytest.mark.parametrize(("initial", "expected"), [("/b", "/b"), ("__none", "__none"), ("/c", "__none")])
async def test_the_initial_topic(world: World, initial: str, expected: str) -> None:
    async with world.muxing("/a", "/b", initial=initial):
        assert await world.selected() == expected


async def test_a_lazy_mux_subscribes_only_to_the_selected_input(world: World) -> None:
    async with world.muxing("/a", "/b", lazy=True) as inbox:
        await until(lambda: [each.subscriber_count for each in world.inputs.values()] == [1, 0])
        await world.call("/mux/select", "MuxSelect", topic="/b")
        await until(lambda: [each.subscriber_count for each in world.inputs.values()] == [0, 1])
        world.inputs["/b"].publish_raw([string("x")])
        await until(lambda: inbox.payloads == [string("x")])


async def test_a_latched_mux_sends_to_later_subscribers(world: World) -> None:
    async with world.muxing("/a", latch=True) as inbox:
        await until(lambda: world.inputs["/a"].subscriber_count == 1)
        world.inputs["/a"].publish_raw([string("kept")])
        await until(lambda: inbox.payloads == [string("kept")])
        assert (await world.listener.wait_for_message("/out", timeout_s=60)).data == "kept"
