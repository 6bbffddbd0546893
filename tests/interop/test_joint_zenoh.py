"""A node in a ROS 1 graph and in a graph over zenoh at the same time, like a board of `serve --ros1
--ros2`.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest_asyncio

from contract.graphs import (
    SET_BOOL,
    STRING,
    TRUE,
    Inbox,
    answer,
    answer_set_bool,
    string,
    wait_for_nodes,
    wait_for_service,
    wait_for_snapshot,
)
from contract.zenoh_graphs import open_session
from interop.ros1_peers import free_port
from rostether.graph.joint_graph import JointGraph
from rostether.graph.joint_join import JointJoin
from rostether.graph.ports import Graph, ParamValue
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1
from waiting import until


class World:
    """A board in both graphs, and a node in each."""

    def __init__(self, board: JointGraph, ros1: Graph, ros2: Graph, master: MasterServer) -> None:
        self.board = board
        self.ros1 = ros1
        self.ros2 = ros2
        self.master = master


@pytest_asyncio.fixture
async def world() -> AsyncIterator[World]:
    async with AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        join = functools.partial(join_ros1, environment=RosEnvironment.read({}).with_master(master.uri))
        port = free_port()
        sessions = [await open_session(port, is_router=is_first) for is_first in (True, False)]
        for session in sessions:
            stack.push_async_callback(session.close)
        board = await JointJoin([join, sessions[0].join])("/board")
        stack.push_async_callback(board.close)
        ros1, ros2 = await join("/peer"), await sessions[1].join("/peer")
        stack.push_async_callback(ros1.close)
        stack.push_async_callback(ros2.close)
        await wait_for_nodes(board._graphs[1], ros2)
        yield World(board, ros1, ros2, master)


async def test_messages_of_both_graphs_and_own_messages_arrive_once(world: World) -> None:
    inboxes, own_inbox = {"1": Inbox(), "2": Inbox()}, Inbox()
    publisher = await world.board.advertise("/chat", STRING, latch=True)
    await world.board.subscribe("/chat", STRING, own_inbox.store)
    await world.ros1.subscribe("/chat", STRING, inboxes["1"].store)
    await world.ros2.subscribe("/chat", STRING, inboxes["2"].store)
    await until(lambda: publisher.subscriber_count >= 3)
    publisher.publish_raw([string("hello")])
    await until(lambda: all(inbox.payloads == [string("hello")] for inbox in inboxes.values()))
    talkers = [await graph.advertise("/chat", STRING) for graph in (world.ros1, world.ros2)]
    await until(lambda: all(talker.subscriber_count >= 2 for talker in talkers))
    for number, talker in enumerate(talkers):
        talker.publish_raw([string(f"from {number}")])
    expected = sorted([string("hello"), string("from 0"), string("from 1")])
    await until(lambda: sorted(own_inbox.payloads) == expected)
    # Anything else would be a duplicate of the node's message.
    await asyncio.sleep(0.05)
    assert sorted(own_inbox.payloads) == expected


async def test_services_of_both_graphs(world: World) -> None:
    await world.board.advertise_service("/switch", SET_BOOL, answer_set_bool)
    for peer in (world.ros1, world.ros2):
        await wait_for_service(peer, "/switch")
        assert await peer.call_service("/switch", SET_BOOL, TRUE, timeout_s=60) == answer("done")
    for number, peer in enumerate((world.ros1, world.ros2)):
        await peer.advertise_service(f"/peer{number}", SET_BOOL, answer_set_bool)
        await wait_for_service(world.board, f"/peer{number}")
        called = await world.board.call_service(f"/peer{number}", SET_BOOL, TRUE, timeout_s=60)
        assert called == answer("done")


async def test_parameters_of_either_graph(world: World) -> None:
    seen: list[ParamValue] = []
    await world.board.watch_param("~gain", seen.append)
    await world.ros2.set_param("/board/gain", 2.5)
    await until(lambda: seen == [None, 2.5])
    assert await world.board.get_param("~gain") == 2.5
    await world.ros1.set_param("/board/gain", 1.5)
    await until(lambda: seen == [None, 2.5, 1.5])
    assert await world.board.get_param("~gain") == 1.5
    assert "/board/gain" in await world.board.list_params()


async def test_ros2_works_after_the_end_of_the_master(world: World) -> None:
    inbox = Inbox()
    publisher = await world.board.advertise("/before", STRING)
    await world.master.close()
    late = await asyncio.wait_for(world.board.advertise("/after", STRING), 60)
    for topic, talker in (("/before", publisher), ("/after", late)):
        await world.ros2.subscribe(topic, STRING, inbox.store)
        await until(lambda: talker.subscriber_count)  # noqa: B023 - awaited at once
        talker.publish_raw([string(topic)])
    await until(lambda: inbox.payloads == [string("/before"), string("/after")])
    await wait_for_snapshot(world.board, lambda snapshot: "/after" in snapshot.topics)
