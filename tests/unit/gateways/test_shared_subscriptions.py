from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from rostether.errors import GraphError, InvalidNameError
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection, SharedSubscriptions
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from waiting import until

TOPIC = "/chatter"
STRING = Registry().message_type("std_msgs/String")
OWN = MessageType("our_msgs/Level", "f" * 32, "uint8 level\n")
HELLO = b"\x05\0\0\0hello"
BYE = b"\x03\0\0\0bye"


@pytest.fixture
async def network() -> AsyncIterator[MemoryNetwork]:
    yield MemoryNetwork()


@pytest.fixture
async def talker(network: MemoryNetwork) -> AsyncIterator[MemoryGraph]:
    graph = await network.join("/talker")
    yield graph
    await graph.close()


@pytest.fixture
async def gateway(network: MemoryNetwork) -> AsyncIterator[MemoryGraph]:
    graph = await network.join("/gateway")
    yield graph
    await graph.close()


@pytest.fixture
async def shared(gateway: MemoryGraph) -> AsyncIterator[SharedSubscriptions]:
    subscriptions = SharedSubscriptions(gateway, TypeStore(Registry()))
    yield subscriptions
    await subscriptions.close()


async def listeners(graph: MemoryGraph) -> tuple[str, ...]:
    topic = (await graph.snapshot()).topics.get(TOPIC)
    return topic.subscribers if topic is not None else ()


class Taker:
    def __init__(self) -> None:
        self.batches: list[Batch] = []
        self.met: list[PublisherConnection] = []

    @property
    def payloads(self) -> list[bytes]:
        return [payload for batch in self.batches for payload in batch.payloads]


async def test_several_takers_share_one_subscription_and_its_batches(
    shared: SharedSubscriptions, talker: MemoryGraph
) -> None:
    publisher = await talker.advertise(TOPIC, STRING)
    first, second = Taker(), Taker()
    await shared.subscribe(TOPIC, first.batches.append, first.met.append)
    await shared.subscribe("chatter", second.batches.append, second.met.append)
    await until(lambda: publisher.subscriber_count)
    assert publisher.subscriber_count == 1
    assert list(shared._sources) == [TOPIC]
    publisher.publish_raw([HELLO, BYE])
    await until(lambda: second.payloads)
    assert first.payloads == second.payloads == [HELLO, BYE]
    assert first.batches[0] is second.batches[0]
    connection = first.batches[0].connection
    assert connection.type == STRING
    assert connection.node_name == "/talker"
    assert connection.codec.decode(BYE).data == "bye"
    assert second.met == first.met == [connection]


async def test_the_last_to_leave_frees_the_topic(
    shared: SharedSubscriptions, talker: MemoryGraph, gateway: MemoryGraph
) -> None:
    publisher = await talker.advertise(TOPIC, STRING)
    staying, leaving = Taker(), Taker()
    kept = await shared.subscribe(TOPIC, staying.batches.append)
    left = await shared.subscribe(TOPIC, leaving.batches.append)
    await left.close()
    await left.close()
    publisher.publish_raw([HELLO])
    await until(lambda: staying.payloads)
    assert leaving.payloads == []
    assert await listeners(gateway) == ("/gateway",)
    await kept.close()
    assert await listeners(gateway) == ()
    assert not shared._sources
    again = Taker()
    await shared.subscribe(TOPIC, again.batches.append)
    publisher.publish_raw([BYE])
    await until(lambda: again.payloads)
    assert again.payloads == [BYE]


async def test_a_late_taker_gets_what_is_latched_once(
    shared: SharedSubscriptions, talker: MemoryGraph
) -> None:
    publisher = await talker.advertise(TOPIC, STRING, latch=True)
    publisher.publish_raw([BYE, HELLO])
    first, late = Taker(), Taker()
    await shared.subscribe(TOPIC, first.batches.append)
    await until(lambda: first.payloads)
    await shared.subscribe(TOPIC, late.batches.append, late.met.append)
    assert late.payloads == [HELLO]
    assert late.met == [late.batches[0].connection]
    publisher.publish_raw([BYE])
    await until(lambda: len(late.payloads) > 1)
    assert first.payloads == [HELLO, BYE]


async def test_what_a_node_latched_goes_with_it(shared: SharedSubscriptions, network: MemoryNetwork) -> None:
    leaving = await network.join("/leaving")
    (await leaving.advertise(TOPIC, STRING, latch=True)).publish_raw([HELLO])
    first, late = Taker(), Taker()
    await shared.subscribe(TOPIC, first.batches.append)
    await until(lambda: first.payloads)
    await leaving.close()
    await shared.subscribe(TOPIC, late.batches.append)
    assert late.payloads == []


async def test_an_unknown_type_is_learned_from_its_publisher(
    shared: SharedSubscriptions, talker: MemoryGraph
) -> None:
    publisher = await talker.advertise(TOPIC, OWN)
    taker = Taker()
    await shared.subscribe(TOPIC, taker.batches.append)
    publisher.publish_raw([b"\x07"])
    await until(lambda: taker.payloads)
    assert taker.batches[0].connection.codec.decode(b"\x07").level == 7


async def test_a_taker_that_fails_leaves_the_others_alone(
    shared: SharedSubscriptions, talker: MemoryGraph, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(batch: Batch) -> None:
        raise ValueError("no")

    publisher = await talker.advertise(TOPIC, STRING)
    taker = Taker()
    await shared.subscribe(TOPIC, fail)
    await shared.subscribe(TOPIC, taker.batches.append)
    publisher.publish_raw([HELLO])
    await until(lambda: taker.payloads)
    assert "subscriber of /chatter failed: ValueError: no" in caplog.text


async def test_concurrent_callers_share_and_a_cancelled_one_does_no_harm(
    shared: SharedSubscriptions, talker: MemoryGraph
) -> None:
    publisher = await talker.advertise(TOPIC, STRING)
    taker = Taker()
    given_up = asyncio.ensure_future(shared.subscribe(TOPIC, Taker().batches.append))
    kept = asyncio.ensure_future(shared.subscribe(TOPIC, taker.batches.append))
    await asyncio.sleep(0)
    given_up.cancel()
    await kept
    publisher.publish_raw([HELLO])
    await until(lambda: taker.payloads)
    assert publisher.subscriber_count == 1


async def test_names_that_break_the_rules_are_refused(shared: SharedSubscriptions) -> None:
    with pytest.raises(InvalidNameError):
        await shared.subscribe("not a name", Taker().batches.append)


async def test_a_graph_that_refuses_is_asked_again_by_the_next(
    shared: SharedSubscriptions, gateway: MemoryGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def refuse(*_: object, **__: object) -> None:
        raise GraphError("not now")

    with monkeypatch.context() as patched:
        patched.setattr(gateway, "subscribe", refuse)
        with pytest.raises(GraphError, match="not now"):
            await shared.subscribe(TOPIC, Taker().batches.append)
        assert not shared._sources
    await shared.subscribe(TOPIC, Taker().batches.append)
    assert list(shared._sources) == [TOPIC]
