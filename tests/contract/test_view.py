"""Snapshots of the whole graph, logs, the time, and leaving the graph."""

from __future__ import annotations

import asyncio
import struct
import time

from contract.capabilities import Capabilities
from contract.graphs import SET_BOOL, STRING, Inbox, answer, string, wait_for_snapshot
from rostether.graph.log_message import LOG_TYPE, ROSOUT
from rostether.graph.ports import JoinGraph, Level, Snapshot
from rostether.graph.ros_clock import CLOCK_TOPIC, CLOCK_TYPE
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.rostime import Time
from waiting import until


async def answer_success(_: bytes) -> bytes:
    return answer()


async def test_a_snapshot_has_all_nodes_topics_and_services(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    await talker.advertise("/chat", STRING)
    await listener.subscribe("/chat", ANY_MESSAGE, Inbox().store)
    await listener.subscribe("/unknown", ANY_MESSAGE, Inbox().store)
    await talker.advertise_service("/switch", SET_BOOL, answer_success)

    def is_complete(snapshot: Snapshot) -> bool:
        chat, rosout = snapshot.topics.get("/chat"), snapshot.topics.get(ROSOUT)
        return bool(
            chat
            and (chat.publishers and chat.subscribers)
            and (rosout and {"/talker", "/listener"} <= set(rosout.publishers))
            and "/switch" in snapshot.services
        )

    snapshot = await wait_for_snapshot(listener, is_complete)
    assert {"/talker", "/listener"} <= set(snapshot.nodes)
    chat = snapshot.topics["/chat"]
    assert (chat.name, chat.type) == ("/chat", capabilities.string_type)
    assert (chat.publishers, chat.subscribers) == (("/talker",), ("/listener",))
    if capabilities.lists_untyped_subscribers or "/unknown" in snapshot.topics:
        assert snapshot.topics["/unknown"].type == "*"
        assert snapshot.topics["/unknown"].publishers == ()
    assert snapshot.services["/switch"].providers == ("/talker",)
    assert snapshot.services["/switch"].type == capabilities.service_type
    assert set(snapshot.topics[ROSOUT].publishers) >= {"/talker", "/listener"}
    assert list(snapshot.topics) == sorted(snapshot.topics)


async def test_changes_yield_snapshots(join: JoinGraph) -> None:
    watcher, other = await join("/watcher"), await join("/other")
    changes = watcher.changes()
    first = await anext(changes)
    assert "/chat" not in first.topics

    async def wait_for_topic(topic: str, *, exists: bool) -> Snapshot:
        while True:
            snapshot = await asyncio.wait_for(anext(changes), 60)
            if (topic in snapshot.topics) is exists:
                return snapshot

    publisher = await other.advertise("/chat", STRING)
    snapshot = await wait_for_topic("/chat", exists=True)
    assert snapshot.topics["/chat"].publishers == ("/other",)
    await publisher.close()
    await wait_for_topic("/chat", exists=False)
    ended = asyncio.ensure_future(anext(changes, None))
    await watcher.close()
    await asyncio.wait_for(ended, 60)


async def test_logs_are_published_under_the_nodes_name(join: JoinGraph, capabilities: Capabilities) -> None:
    node, listener, inbox = await join("/node"), await join("/listener"), Inbox()
    # Latched: a later subscriber receives the last message.
    node.log(Level.WARN, "too hot: 90 °C")
    await listener.subscribe(ROSOUT, LOG_TYPE, inbox.store)
    named = string(capabilities.logger_of_node) + string("too hot: 90 °C")
    await until(lambda: any(named in each for each in inbox.payloads))
    (payload,) = [each for each in inbox.payloads if named in each]
    assert payload[16] == Level.WARN
    stamp_s = int.from_bytes(payload[4:8], "little")
    assert abs(stamp_s - time.time()) < 60


async def test_time_is_the_wall_clock(join: JoinGraph) -> None:
    node = await join("/node")
    assert abs(node.now().to_s() - time.time()) < 60


async def test_simulated_time_is_that_of_clock(join: JoinGraph, capabilities: Capabilities) -> None:
    capabilities.require("simulates_time")
    simulator = await join("/simulator")
    publisher = await simulator.advertise(CLOCK_TOPIC, CLOCK_TYPE)
    if capabilities.global_parameters:
        await simulator.set_param("/use_sim_time", True)
        node = await join("/node")
    else:
        node = await join("/node")
        await node.set_param("~use_sim_time", True)
    await until(lambda: node.now() == Time())
    await until(lambda: publisher.subscriber_count)

    def tick() -> bool:
        # Some simulators publish the time best effort, and some subscribers accept that.
        publisher.publish_raw([struct.pack("<II", 12, 7)])
        return node.now() == Time(12, 7)

    await until(tick)


async def test_all_registrations_of_a_node_end_when_it_leaves(join: JoinGraph) -> None:
    leaving, staying, inbox = await join("/leaving"), await join("/staying"), Inbox()
    publisher = await leaving.advertise("/chat", STRING)
    subscriber = await staying.subscribe("/chat", STRING, inbox.store)
    kept = await staying.advertise("/back", STRING)
    await leaving.subscribe("/back", STRING, inbox.store)
    await leaving.advertise_service("/switch", SET_BOOL, answer_success)
    await until(lambda: publisher.subscriber_count == kept.subscriber_count == 1)
    closed = asyncio.ensure_future(leaving.wait_closed())
    await leaving.close()
    await leaving.close()
    assert await closed == "closed"
    await until(lambda: subscriber.publisher_count == kept.subscriber_count == 0)
    snapshot = await wait_for_snapshot(
        staying, lambda snapshot: "/leaving" not in snapshot.nodes and "/switch" not in snapshot.services
    )
    assert snapshot.topics["/chat"].publishers == ()
    assert snapshot.topics["/back"].subscribers == ()
    assert "/leaving" not in snapshot.topics[ROSOUT].publishers


async def test_a_new_node_of_the_same_name_replaces_the_old_one(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    capabilities.require("same_name_replaces")
    old = await join("/node")
    await old.advertise("/chat", STRING)
    new = await join("/node")
    publisher = await new.advertise("/chat", STRING)
    assert "new node registered with same name" in await asyncio.wait_for(old.wait_closed(), 60)
    inbox = Inbox()
    listener = await join("/listener")
    await listener.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    assert (await new.snapshot()).topics["/chat"].publishers == ("/node",)
