"""A relay between two graphs: what it relays and when, and that no message comes back."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from contract.graphs import BOOL, EMPTY, SET_BOOL, STRING, TRUE, Inbox, answer, answer_set_bool, string
from rostether.errors import GraphError, ServiceUnavailableError
from rostether.graph.memory_network import MemoryGraph
from rostether.graph.static_transforms import StaticTransforms
from rostether.msgdef.interface import ServiceType
from rostether.msgdef.registry import Registry
from rostether.relay import relay as relay_module
from rostether.relay.relay import Relay
from rostether.relay.relay_filter import RelayDirection, RelayFilter, ServiceFilter, TopicFilter
from rostether.relay.side import RelaySide
from rostether.serde.store import TypeStore
from unit.relay.relay_world import World, service_type
from waiting import until


async def test_topics_are_relayed_in_both_directions_and_nothing_comes_back(world: World) -> None:
    inboxes = Inbox(), Inbox()
    talkers = [await graph.advertise("/chat", STRING) for graph in (world.one, world.two)]
    for graph, inbox in zip((world.one, world.two), inboxes, strict=True):
        await graph.subscribe("/chat", STRING, inbox.store)
    async with world.relaying(TopicFilter("/chat")):
        await until(lambda: world.carries("/chat", 0) and world.carries("/chat", 1))
        await until(lambda: all(talker.subscriber_count == 2 for talker in talkers))
        for number in range(3):
            talkers[0].publish_raw([string(f"one {number}")])
            talkers[1].publish_raw([string(f"two {number}")])
        expected = sorted(string(f"{name} {number}") for name in ("one", "two") for number in range(3))
        await until(lambda: all(sorted(inbox.payloads) == expected for inbox in inboxes))
        await asyncio.sleep(0.02)
        assert all(sorted(inbox.payloads) == expected for inbox in inboxes)
        assert "relaying /chat from one to two (std_msgs/String)" in world.lines
        assert "relaying /chat from two to one (std_msgs/String)" in world.lines
    assert not world.carries("/chat", 0)
    assert not world.carries("/chat", 1)
    assert "no longer relaying /chat from one to two" in world.lines


async def test_only_chosen_topics_are_relayed(world: World) -> None:
    for graph in (world.one, world.two):
        for topic in ("/forth/a", "/back/a", "/other", "/clock"):
            await graph.advertise(topic, STRING)
    chosen = (
        TopicFilter("/forth/*", RelayDirection.FIRST_TO_SECOND),
        TopicFilter("/back/*", RelayDirection.SECOND_TO_FIRST),
        TopicFilter("/ro*"),
    )
    async with world.relaying(*chosen):
        await until(lambda: world.carries("/forth/a", 1) and world.carries("/back/a", 0))
        await asyncio.sleep(0.01)
        assert not world.carries("/forth/a", 0)
        assert not world.carries("/back/a", 1)
        for number in (0, 1):
            assert not world.carries("/other", number)
            assert not world.carries("/clock", number)
        assert not any("/rosout" in line for line in world.lines)


async def test_a_topic_is_relayed_as_long_as_it_is_published(world: World) -> None:
    inbox = Inbox()
    await world.two.subscribe("/chat", STRING, inbox.store)
    async with world.relaying(TopicFilter("/chat")):
        for number in range(3):
            talker = await world.one.advertise("/chat", STRING)
            await until(lambda: world.carries("/chat", 1) and talker.subscriber_count)  # noqa: B023
            talker.publish_raw([string(f"{number}")])
            await until(lambda: len(inbox.payloads) == number + 1)  # noqa: B023
            await talker.close()
            await until(lambda: not world.carries("/chat", 1))
    assert inbox.payloads == [string("0"), string("1"), string("2")]


async def test_messages_published_right_after_the_first_connection_arrive_once_and_in_order(
    world: World,
) -> None:
    inbox = Inbox()
    await world.two.subscribe("/chat", STRING, inbox.store)
    talker = await world.one.advertise("/chat", STRING)
    async with world.relaying(TopicFilter("/chat")):
        while not talker.subscriber_count:
            await asyncio.sleep(0)
        expected = [string(f"{number}") for number in range(300)]
        for payload in expected:
            talker.publish_raw([payload])
            await asyncio.sleep(0)
        await until(lambda: len(inbox.payloads) >= len(expected))
    assert inbox.payloads == expected


async def test_a_topic_whose_type_changes_is_still_relayed(world: World) -> None:
    talker = await world.one.advertise("/chat", STRING)
    async with world.relaying(TopicFilter("/chat")):
        await until(lambda: world.carries("/chat", 1))
        await talker.close()
        talker = await world.one.advertise("/chat", BOOL, latch=True)
        talker.publish_raw([TRUE])
        await until(lambda: "relaying /chat from one to two (std_msgs/Bool)" in world.lines)
        inbox = Inbox()
        await world.two.subscribe("/chat", BOOL, inbox.store)
        await until(lambda: inbox.payloads)
    assert inbox.payloads == [TRUE]


async def test_latched_topics_are_latched_in_the_other_graph(world: World) -> None:
    talker = await world.one.advertise("/map", STRING, latch=True)
    talker.publish_raw([string("the map")])
    async with world.relaying(TopicFilter("/map")):
        await until(lambda: world.carries("/map", 1))
        for _ in range(2):
            inbox = Inbox()
            await world.two.subscribe("/map", STRING, inbox.store, on_connection=inbox.store_header)
            await until(lambda: inbox.payloads)  # noqa: B023 - awaited at once
            assert inbox.payloads == [string("the map")]
            assert inbox.headers[0]["latching"] == "1"


async def test_a_late_subscriber_receives_the_static_transforms_of_all_publishers(world: World) -> None:
    store = TypeStore(Registry())
    codec, message_type = (
        store.codec("tf2_msgs/TFMessage"),
        store.registry.message_type("tf2_msgs/TFMessage"),
    )

    async def broadcast(frame: str) -> None:
        node = await world.networks[0].join(f"/{frame}")
        talker = await node.advertise("/tf_static", message_type, latch=True)
        transform = {"header": {"frame_id": "base"}, "child_frame_id": frame}
        talker.publish_raw([codec.encode({"transforms": [transform]})])

    await broadcast("lidar")
    first = Inbox()
    await world.two.subscribe("/tf_static", message_type, first.store)
    async with world.relaying(TopicFilter("/tf_static")):
        await until(lambda: world.carries("/tf_static", 1))
        await broadcast("camera")
        await until(lambda: len(first.payloads) == 2)
        inbox = Inbox()
        await world.two.subscribe("/tf_static", message_type, inbox.store)
        await until(lambda: inbox.payloads)
    frames = [each.child_frame_id for each in codec.decode(inbox.payloads[0]).transforms]
    assert sorted(frames) == ["camera", "lidar"]
    # A message that is not a list of transforms is not changed.
    assert StaticTransforms().merge(b"\2\0\0\0short") == b"\2\0\0\0short"


async def test_a_slow_subscriber_slows_the_publisher_in_the_other_graph(world: World) -> None:
    talker = await world.one.advertise("/chat", STRING)
    inbox = Inbox()
    slow = await world.two.subscribe("/chat", STRING, inbox.store)
    async with world.relaying(TopicFilter("/chat", RelayDirection.FIRST_TO_SECOND)):
        await until(lambda: talker.subscriber_count and slow.publisher_count)
        slow.pause()
        sent = 0
        while talker.publish_raw([string("x" * 10000)]):
            sent += 1
            await asyncio.sleep(0)
            assert sent < 10000
        slow.resume()
        await talker.drained(10.0)
        await until(lambda: len(inbox.payloads) == sent + 1)
        assert talker.dropped_count == 0


async def test_services_are_offered_where_they_are_missing(world: World) -> None:
    handle = await world.one.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await world.one.advertise_service("/shared", SET_BOOL, answer_set_bool)
    await world.two.advertise_service("/shared", SET_BOOL, answer_set_bool)
    await world.one.advertise_service("/node/list_parameters", EMPTY, answer_set_bool)

    async def refuse(_: bytes) -> bytes:
        raise GraphError("not today")

    await world.two.advertise_service("/refuse", SET_BOOL, refuse)
    async with world.relaying(services=(ServiceFilter("/*"),)):
        await until(lambda: len(world.relayed) == 2)
        assert await world.two.call_service("/switch", SET_BOOL, TRUE) == answer("done")
        with pytest.raises(GraphError, match="not today"):
            await world.one.call_service("/refuse", SET_BOOL, TRUE)
        assert world.relayed == {
            "service /switch from one to two",
            "service /refuse from two to one",
        }
        await handle.close()
        await until(lambda: len(world.relayed) == 1)
        with pytest.raises(ServiceUnavailableError):
            await world.two.call_service("/switch", SET_BOOL, TRUE)
        # There are two servers now, so the relay withdraws its own.
        await world.one.advertise_service("/refuse", SET_BOOL, answer_set_bool)
        await until(lambda: not world.relayed)
        assert await world.one.call_service("/refuse", SET_BOOL, TRUE) == answer("done")


async def test_an_unknown_service_type_is_reported_once_and_can_be_given(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(relay_module, "RETRY_S", 0.001)
    odd = ServiceType("own/Odd", SET_BOOL.md5sum, SET_BOOL.request, SET_BOOL.response)
    await world.one.advertise_service("/odd", odd, answer_set_bool)
    trouble = "cannot relay service /odd from one to two: no definition of own/Odd, the type of /odd; "
    async with world.relaying(services=(ServiceFilter("/odd"),)):
        await until(lambda: world.lines)
        await asyncio.sleep(0.02)
        assert world.lines == [f"{trouble}or give it as /odd=package/Type"]
    async with world.relaying(services=(ServiceFilter("/odd", "std_srvs/SetBool"),)):
        await until(lambda: world.relayed)
        assert await world.two.call_service("/odd", SET_BOOL, TRUE) == answer("done")


async def test_refused_requests_are_tried_again(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relay_module, "RETRY_S", 0.001)
    taken = True
    advertise: Callable[..., object] = MemoryGraph.advertise

    async def refuse(self: MemoryGraph, topic: str, *args: object, **kwargs: object) -> object:
        if taken and topic == "/chat":
            raise GraphError("no room")
        return await advertise(self, topic, *args, **kwargs)  # type: ignore[misc]

    await world.one.advertise("/chat", STRING)
    monkeypatch.setattr(MemoryGraph, "advertise", refuse)
    async with world.relaying(TopicFilter("/chat")):
        await until(lambda: "cannot relay /chat from one to two: no room" in world.lines)
        await asyncio.sleep(0.01)
        assert len(world.lines) == 1
        taken = False
        await until(lambda: world.carries("/chat", 1))


async def test_a_node_shutdown_ends_the_relay(world: World) -> None:
    sides = [RelaySide(str(number), graph, service_type) for number, graph in enumerate(world.relays)]
    relay = Relay(sides[0], sides[1], RelayFilter(), lambda _level, _text: None)
    running = asyncio.ensure_future(relay.run())
    await asyncio.sleep(0)
    await world.networks[1].join("/relay")
    with pytest.raises(GraphError, match="the relay's node has left 1: new node registered"):
        await asyncio.wait_for(running, 60)


@pytest.mark.parametrize(
    ("topics", "name", "direction", "carried"),
    [
        (TopicFilter("/a"), "/a", RelayDirection.FIRST_TO_SECOND, True),
        (TopicFilter("/a"), "/a/b", RelayDirection.FIRST_TO_SECOND, False),
        (TopicFilter("/a/*"), "/a/b/c", RelayDirection.SECOND_TO_FIRST, True),
        (TopicFilter("/a", RelayDirection.FIRST_TO_SECOND), "/a", RelayDirection.SECOND_TO_FIRST, False),
        (TopicFilter("*"), "/rosout", RelayDirection.FIRST_TO_SECOND, False),
        (TopicFilter("*"), "/parameter_events", RelayDirection.FIRST_TO_SECOND, False),
        (TopicFilter("/clock"), "/clock", RelayDirection.FIRST_TO_SECOND, True),
    ],
)
def test_the_filter_chooses_topics(
    topics: TopicFilter, name: str, direction: RelayDirection, *, carried: bool
) -> None:
    assert RelayFilter((topics,)).relays_topic(name, direction) is carried


def test_the_filter_chooses_services() -> None:
    choice = RelayFilter(services=(ServiceFilter("/lab/*", "a/B"), ServiceFilter("/node/get_loggers")))
    assert choice.service("/lab/switch") == ServiceFilter("/lab/*", "a/B")
    assert choice.service("/lab/node/set_parameters") is None
    assert choice.service("/node/get_loggers") == ServiceFilter("/node/get_loggers")
    assert choice.service("/other") is None
