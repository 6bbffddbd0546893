from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from contract.graphs import STRING, Inbox, string
from rostether.errors import ConfigError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.nodes.forwarding import ByteThrottle, MessageThrottle, Select, all_messages, forward
from waiting import until

NETWORK_NODES = ("/talker", "/relay", "/listener")


class World:
    def __init__(self) -> None:
        self.network = MemoryNetwork()

    async def join(self) -> World:
        self.talker, self.relay, self.listener = [await self.network.join(name) for name in NETWORK_NODES]
        return self

    @asynccontextmanager
    async def forwarding(
        self, source: str, target: str, select: Select = all_messages, *, lazy: bool = False
    ) -> AsyncIterator[None]:
        running = asyncio.ensure_future(forward(self.relay, source, target, select, lazy=lazy))
        try:
            yield
        finally:
            running.cancel()
            await asyncio.wait([running])

    def publishers(self, topic: str) -> tuple[str, ...]:
        found = self.network.snapshot().topics.get(topic)
        return found.publishers if found is not None else ()

    def subscribers(self, topic: str) -> tuple[str, ...]:
        found = self.network.snapshot().topics.get(topic)
        return found.subscribers if found is not None else ()


async def listen(graph: MemoryGraph, topic: str) -> Inbox:
    inbox = Inbox()
    await graph.subscribe(topic, STRING, inbox.store)
    return inbox


async def test_a_relay_publishes_messages_with_their_type() -> None:
    world = await World().join()
    talker = await world.talker.advertise("/a", STRING)
    async with world.forwarding("/a", "/b"):
        await until(lambda: world.publishers("/b") == ("/relay",))
        inbox = await listen(world.listener, "/b")
        await until(lambda: talker.subscriber_count == 1)
        talker.publish_raw([string("one"), string("two")])
        await until(lambda: inbox.payloads == [string("one"), string("two")])
        assert world.network.snapshot().topics["/b"].type == "std_msgs/String"
    assert world.publishers("/b") == ()
    assert world.subscribers("/a") == ()


async def test_a_latched_topic_stays_latched() -> None:
    world = await World().join()
    talker = await world.talker.advertise("/a", STRING, latch=True)
    talker.publish_raw([string("kept")])
    async with world.forwarding("/a", "/b"):
        await until(lambda: world.publishers("/b") == ("/relay",))
        inbox = await listen(world.listener, "/b")
        await until(lambda: inbox.payloads == [string("kept")])


async def test_a_lazy_relay_subscribes_only_while_it_has_subscribers() -> None:
    world = await World().join()
    talker = await world.talker.advertise("/a", STRING)
    async with world.forwarding("/a", "/b", lazy=True):
        await until(lambda: world.publishers("/b") == ("/relay",) and not world.subscribers("/a"))
        inbox = Inbox()
        subscriber = await world.listener.subscribe("/b", STRING, inbox.store)
        await until(lambda: talker.subscriber_count == 1)
        talker.publish_raw([string("x")])
        await until(lambda: inbox.payloads == [string("x")])
        await subscriber.close()
        await until(lambda: talker.subscriber_count == 0)


async def test_a_topic_is_never_its_own_source() -> None:
    world = await World().join()
    with pytest.raises(ConfigError, match="/a would receive its own output"):
        await forward(world.relay, "/a", "a")


async def test_a_throttle_forwards_some_of_the_messages() -> None:
    world = await World().join()
    talker = await world.talker.advertise("/a", STRING)
    clock_s = 100.0
    async with world.forwarding("/a", "/b", MessageThrottle(2.0, lambda: clock_s)):
        await until(lambda: world.publishers("/b") == ("/relay",))
        inbox = await listen(world.listener, "/b")
        talker.publish_raw([string("a"), string("b")])
        await until(lambda: inbox.payloads == [string("a")])
        clock_s = 100.6
        talker.publish_raw([string("c")])
        await until(lambda: inbox.payloads == [string("a"), string("c")])


def test_message_rate() -> None:
    clock_s = 1000.0

    def now_s() -> float:
        return clock_s

    rate = MessageThrottle(8.0, now_s)
    assert rate([b"a", b"b"]) == [b"a"]
    for later_s, expected in ((0.0625, ()), (0.125, ()), (0.1875, [b"c"]), (0.25, ()), (0.5, [b"c"])):
        clock_s = 1000.0 + later_s
        assert rate([b"c"]) == expected
    # The clock jumps back, like that of a restarted simulation: the interval restarts.
    clock_s = 5.0
    assert rate([b"d"]) == ()
    clock_s = 5.2
    assert rate([b"d"]) == [b"d"]
    assert rate([]) == ()


def test_without_a_clock_no_message_passes() -> None:
    assert MessageThrottle(10.0, lambda: 0.0)([b"a"]) == ()


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("nan")])
def test_a_rate_must_be_above_zero(rate_hz: float) -> None:
    with pytest.raises(ConfigError, match="give more than 0"):
        MessageThrottle(rate_hz, lambda: 0.0)


def test_byte_rate() -> None:
    clock_s = 0.0

    def now_s() -> float:
        return clock_s

    rate = ByteThrottle(10, 1.0, now_s)
    # The message that exceeds the limit is still forwarded, as in topic_tools.
    assert rate([b"x" * 6] * 3) == [b"x" * 6] * 2
    clock_s = 1.0
    assert rate([b"y"]) == []
    clock_s = 1.01
    assert rate([b"y"]) == [b"y"]
