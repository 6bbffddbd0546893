from __future__ import annotations

import asyncio
import struct
from collections.abc import Callable

import pytest

from rostether.bridge.endpoint.publisher import HELD_BYTES, PublisherEndpoint
from rostether.bridge.settings import BridgeSettings
from rostether.errors import TypeMismatchError
from rostether.graph.ports import Graph
from rostether.mechanisms.rate_limits import TokenBucket
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, text, topic_info
from waiting import until


def endpoint(
    world: World,
    type_name: str = "std_msgs/String",
    graph: Graph | None = None,
    messages_hz: float | None = None,
    admit: Callable[[int], int] | None = None,
) -> PublisherEndpoint:
    return PublisherEndpoint(
        topic_info("chatter", type_name),
        STORE,
        graph if graph is not None else world.board,
        world.notices,
        BridgeSettings(messages_hz=messages_hz),
        admit,
    )


@pytest.fixture
async def world() -> World:
    return await World().open()


async def test_messages_reach_the_graph_in_order(world: World) -> None:
    received, line, chatter = await world.listen("/chatter"), FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    await chatter.open()
    line.receivers[125]([text("one"), text("two")])
    line.receivers[125]([text("three")])
    await until(lambda: len(received) == 3, "three messages")
    assert received == [text("one"), text("two"), text("three")]
    assert chatter.message_count == 3


async def test_messages_before_the_topic_is_advertised_are_kept(world: World) -> None:
    received, line, chatter = await world.listen("/chatter"), FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    line.receivers[125]([text("early")])
    await chatter.open()
    line.receivers[125]([text("late")])
    await until(lambda: len(received) == 2, "both messages")
    assert received == [text("early"), text("late")]


async def test_a_flood_before_the_topic_is_advertised_pauses_the_board(world: World) -> None:
    line, chatter = FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    line.receivers[125]([text("x" * 1000)] * (HELD_BYTES // 1000))
    assert len(line.waits) == 1
    waiting = asyncio.ensure_future(line.waits[0]())
    await asyncio.sleep(0)
    assert not waiting.done()
    await chatter.open()
    await waiting
    assert chatter.dropped_count == 0


async def test_a_flood_that_cannot_be_paused_is_kept_within_bounds(world: World) -> None:
    received, line, chatter = await world.listen("/chatter"), FakeLine(can_pause=False), endpoint(world)
    chatter.attach(line, chatter.info)
    for number in range(1000):
        line.receivers[125]([text(f"{number:01000}")])
    await chatter.open()
    await until(lambda: received, "the newest messages")
    assert received[-1] == text(f"{999:01000}")
    assert len(received) + chatter.dropped_count == 1000
    assert len(received) * 1000 <= HELD_BYTES
    assert len(world.reporter.having("not advertised yet")) == 1


async def test_a_topic_that_is_not_advertised_in_time_pauses_the_board_only_once(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.bridge.endpoint.publisher.SETUP_PAUSE_S", 0.01)
    line, chatter = FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    line.receivers[125]([text("x" * 1000)] * (HELD_BYTES // 1000))
    await line.waits[0]()
    line.receivers[125]([text("x" * 1000)] * 10)
    assert len(line.waits) == 1
    assert chatter.dropped_count > 0


async def test_a_refused_topic_never_pauses_the_board(world: World) -> None:
    line, chatter = FakeLine(), endpoint(world)
    await world.board.advertise("/chatter", STORE.registry.message_type("std_msgs/Int32"))
    chatter.attach(line, chatter.info)
    with pytest.raises(TypeMismatchError):
        await chatter.open()
    line.receivers[125]([text("x" * 1000)] * (HELD_BYTES // 1000))
    assert line.waits == []
    assert chatter.dropped_count > 0
    assert world.reporter.having("not advertised yet") == []


async def test_a_pause_ends_when_the_topic_is_refused(world: World) -> None:
    line, chatter = FakeLine(), endpoint(world)
    await world.board.advertise("/chatter", STORE.registry.message_type("std_msgs/Int32"))
    chatter.attach(line, chatter.info)
    line.receivers[125]([text("x" * 1000)] * (HELD_BYTES // 1000))
    waiting = asyncio.ensure_future(line.waits[0]())
    with pytest.raises(TypeMismatchError):
        await chatter.open()
    await asyncio.wait_for(waiting, 0.5)


async def test_damaged_messages_never_reach_the_graph(world: World) -> None:
    received, line, chatter = await world.listen("/chatter"), FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    await chatter.open()
    for _ in range(100):
        line.receivers[125]([text("good"), b"\x05\0\0\0bad", b""])
    await until(lambda: len(received) == 100, "the good messages")
    assert set(received) == {text("good")}
    assert chatter.misfit_count == 200
    assert len(world.reporter.having("chatter")) == 1
    assert "std_msgs/String" in world.reporter.texts[0]


async def test_a_chunk_with_only_damaged_messages_is_not_published(world: World) -> None:
    received, line, level = (
        await world.listen("/chatter", "std_msgs/UInt16"),
        FakeLine(),
        endpoint(world, "std_msgs/UInt16"),
    )
    level.attach(line, level.info)
    await level.open()
    line.receivers[125]([b"1", b"123"])
    line.receivers[125]([struct.pack("<H", 7)])
    await until(lambda: received, "the good message")
    assert received == [struct.pack("<H", 7)]


async def test_a_congested_subscriber_pauses_the_board(world: World) -> None:
    line, chatter = FakeLine(), endpoint(world)
    subscription = await world.peer.subscribe(
        "/chatter", STORE.registry.message_type("std_msgs/String"), lambda _: None
    )
    subscription.pause()
    chatter.attach(line, chatter.info)
    await chatter.open()
    for _ in range(400):
        line.receivers[125]([text("x" * 1000)])
        if line.waits:
            break
    assert line.waits
    waiting = asyncio.ensure_future(line.waits[0]())
    await asyncio.sleep(0)
    assert not waiting.done()
    subscription.resume()
    await waiting
    assert chatter.lost_count == 0


async def test_a_slow_subscriber_loses_only_its_own_messages_and_they_are_counted(world: World) -> None:
    received, line, chatter = await world.listen("/chatter"), FakeLine(can_pause=False), endpoint(world)
    slow = await world.network.join("/slow")
    subscription = await slow.subscribe(
        "/chatter", STORE.registry.message_type("std_msgs/String"), lambda _: None
    )
    subscription.pause()
    chatter.attach(line, chatter.info)
    await chatter.open()
    for _ in range(80):
        line.receivers[125]([text("x" * 1000)] * 100)
        await asyncio.sleep(0)
    await until(lambda: len(received) == 8000, "all messages at the quick subscriber")
    assert chatter.lost_count > 0
    assert world.reporter.texts == []


async def test_a_detached_endpoint_receives_nothing_and_stays_advertised(world: World) -> None:
    line, chatter = FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    await chatter.open()
    chatter.detach()
    assert line.receivers == {}
    assert "/board" in world.network.snapshot().topics["/chatter"].publishers
    await chatter.close()
    assert "/chatter" not in world.network.snapshot().topics


async def test_attached_again_it_uses_only_the_new_id(world: World) -> None:
    old, new, chatter = FakeLine(), FakeLine(), endpoint(world)
    chatter.attach(old, topic_info(topic_id=125))
    chatter.attach(new, topic_info(topic_id=126))
    assert (list(old.receivers), list(new.receivers)) == ([], [126])


async def test_messages_beyond_the_rate_of_a_board_are_dropped(world: World) -> None:
    now_s = 100.0
    bucket = TokenBucket(10.0, 10.0, now_s)
    chatter = endpoint(world, messages_hz=10.0, admit=lambda count: bucket.admit(count, now_s))
    received, line = await world.listen("/chatter"), FakeLine()
    chatter.attach(line, chatter.info)
    await chatter.open()
    line.receivers[125]([text(str(number)) for number in range(25)])
    line.receivers[125]([text("more")])
    now_s += 0.5
    line.receivers[125]([text(str(number)) for number in range(100, 110)])
    expected = [text(str(number)) for number in (*range(10), *range(100, 105))]
    await until(lambda: len(received) == len(expected), "what is admitted")
    assert received == expected
    assert (chatter.message_count, chatter.dropped_count) == (15, 21)
    assert "sends more than 10 messages a second (its limit messages_hz), and" in world.reporter.texts[-1]


async def test_a_misfit_is_searched_for_frames_in_the_order_of_arrival(world: World) -> None:
    received, line, chatter = await world.listen("/chatter"), FakeLine(), endpoint(world)
    chatter.attach(line, chatter.info)
    await chatter.open()
    swallower = b"\xff\xfe and more"
    line.rescan = lambda payload: chatter.receive([text("swallowed")])  # type: ignore[method-assign]
    line.receivers[125]([text("before"), swallower, text("after"), b"no sync"])
    await until(lambda: len(received) == 3, "three messages")
    assert received == [text("before"), text("swallowed"), text("after")]
    assert chatter.misfit_count == 2


async def test_messages_with_a_header_are_counted_as_ros_clients_count_them(world: World) -> None:
    received = await world.listen("/chatter", "sensor_msgs/Range")
    line, ranges = FakeLine(), endpoint(world, "sensor_msgs/Range")
    payload = STORE.codec("sensor_msgs/Range").encode({"header": {"frame_id": "sonar"}, "range": 0.5})
    ranges.attach(line, ranges.info)
    line.receivers[125]([payload])
    await ranges.open()
    line.receivers[125]([payload, payload])
    ranges.detach()
    ranges.attach(line, ranges.info)
    line.receivers[125]([payload])
    ranges._sequence = 2**32 - 2
    line.receivers[125]([payload] * 3)
    await until(lambda: len(received) == 7, "seven messages")
    assert [int.from_bytes(each[:4], "little") for each in received] == [1, 2, 3, 4, 2**32 - 1, 0, 1]
    assert {each[4:] for each in received} == {payload[4:]}
