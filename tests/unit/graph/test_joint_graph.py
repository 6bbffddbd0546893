"""A node in several graphs, even if a graph is late, hangs or refuses calls."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any, cast

import pytest

from contract.broken_graph import BrokenGraph
from contract.graphs import BOOL, SET_BOOL, STRING, TRUE, Inbox, answer, string
from rostether.errors import (
    GraphError,
    InvalidNameError,
    MasterUnreachableError,
    ServiceCallError,
    ServiceUnavailableError,
    UnknownNameError,
    UnknownTypeError,
)
from rostether.graph import joint_handle
from rostether.graph.joint_graph import JointGraph
from rostether.graph.joint_join import JointJoin
from rostether.graph.joint_marks import MARK_TYPE, new_relay_mark
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Graph, Level, ListsClients, ParamValue, ServiceHandler
from rostether.msgdef.interface import ServiceType
from rostether.ros2.listed_client import ListedClient
from waiting import until


class World:
    """Two graphs, a node in both, and a node in each."""

    def __init__(self, networks: list[MemoryNetwork], joint: JointGraph, others: list[MemoryGraph]) -> None:
        self.networks = networks
        self.joint = joint
        self.others = others


async def make_world() -> World:
    networks = [MemoryNetwork(), MemoryNetwork()]
    joint = await JointJoin([network.join for network in networks])("/board")
    return World(networks, joint, [await network.join("/other") for network in networks])


def answering(text: str) -> ServiceHandler:
    async def handle(_: bytes) -> bytes:
        return answer(text)

    return handle


async def test_it_publishes_to_all_and_receives_from_all() -> None:
    world = await make_world()
    inboxes, mine = [Inbox(), Inbox()], Inbox()
    publisher = await world.joint.advertise("chat", STRING)
    subscriber = await world.joint.subscribe("/back", STRING, mine.store)
    for other, inbox in zip(world.others, inboxes, strict=True):
        await other.subscribe("/chat", STRING, inbox.store)
    talkers = [await other.advertise("/back", STRING) for other in world.others]
    assert publisher.topic == "/chat"
    assert publisher.subscriber_count == subscriber.publisher_count == 2
    publisher.publish_raw([string("hello")])
    await until(lambda: all(inbox.payloads == [string("hello")] for inbox in inboxes))
    for number, talker in enumerate(talkers):
        talker.publish_raw([string(f"from {number}")])
    await until(lambda: sorted(mine.payloads) == [string("from 0"), string("from 1")])
    subscriber.pause()
    talkers[1].publish_raw([string("later")])
    talkers[0].publish_raw([string("later")])
    await asyncio.sleep(0.01)
    assert len(mine.payloads) == 2
    subscriber.resume()
    await until(lambda: mine.payloads[2:] == [string("later")] * 2)
    await publisher.close()
    await subscriber.close()
    await publisher.close()
    assert all(
        "/chat" not in network.snapshot().topics or not network.snapshot().topics["/chat"].publishers
        for network in world.networks
    )
    await world.joint.close()


async def test_its_own_messages_come_once() -> None:
    world = await make_world()
    inbox = Inbox()
    publisher = await world.joint.advertise("/chat", STRING)
    await world.joint.subscribe("/chat", STRING, inbox.store)
    skipping = Inbox()
    await world.joint.subscribe("/chat", STRING, skipping.store, skip_own=True)
    publisher.publish_raw([string("hello")])
    await until(lambda: inbox.payloads)
    await asyncio.sleep(0.01)
    assert inbox.payloads == [string("hello")]
    assert skipping.payloads == []
    await world.joint.close()


async def test_nodes_in_the_same_two_graphs_receive_messages_once() -> None:
    networks = [MemoryNetwork(), MemoryNetwork()]
    join = JointJoin([network.join for network in networks])
    first = await join("/first")
    inbox = Inbox()
    await first.subscribe("/chat", STRING, inbox.store)
    second = await join("/second")
    publisher = await second.advertise("/chat", STRING)
    other = await (await networks[1].join("/other")).advertise("/chat", STRING)
    publisher.publish_raw([string("hello")])
    other.publish_raw([string("me too")])
    await until(lambda: len(inbox.payloads) == 2)
    await asyncio.sleep(0.01)
    assert sorted(inbox.payloads) == [string("hello"), string("me too")]
    for graph in (first, second):
        await graph.close()
    assert not join._own_nodes


async def test_a_slow_subscriber_of_either_graph_pauses_the_publisher() -> None:
    world = await make_world()
    publisher = await world.joint.advertise("/chat", STRING)
    slow = await world.others[1].subscribe("/chat", STRING, Inbox().store)
    slow.pause()
    for _ in range(100):
        is_open = publisher.publish_raw([string("x" * 10000)])
    assert not is_open
    while not publisher.publish_raw([]):
        await publisher.drained(0.001)
    for _ in range(500):
        publisher.publish_raw([string("x" * 10000)])
    assert publisher.dropped_count > 0
    await world.joint.close()


async def test_the_first_graph_that_has_a_service_is_called() -> None:
    world = await make_world()
    with pytest.raises(ServiceUnavailableError):
        await world.joint.call_service("/switch", SET_BOOL, TRUE)
    await world.others[1].advertise_service("/switch", SET_BOOL, answering("second"))
    assert await world.joint.call_service("/switch", SET_BOOL, TRUE) == answer("second")
    await world.others[0].advertise_service("/switch", SET_BOOL, answering("first"))
    assert await world.joint.call_service("/switch", SET_BOOL, TRUE) == answer("first")

    async def refuse(_: bytes) -> bytes:
        raise GraphError("not today")

    # A failure is an answer: no other graph is asked.
    await world.others[0].advertise_service("/refuse", SET_BOOL, refuse)
    await world.others[1].advertise_service("/refuse", SET_BOOL, answering("second"))
    with pytest.raises(ServiceCallError, match="not today"):
        await world.joint.call_service("/refuse", SET_BOOL, TRUE)
    server = await world.joint.advertise_service("/mine", SET_BOOL, answering("mine"))
    for other in world.others:
        assert await other.call_service("/mine", SET_BOOL, TRUE) == answer("mine")
    await server.close()
    for other in world.others:
        with pytest.raises(ServiceUnavailableError):
            await other.call_service("/mine", SET_BOOL, TRUE)
    await world.joint.close()


async def test_parameters_come_from_the_first_graph_that_has_them() -> None:
    world = await make_world()
    first, second = world.others
    await second.set_param("/rate", 2)
    seen: list[ParamValue] = []
    watch = await world.joint.watch_param("/rate", seen.append)
    assert seen == [2]
    assert await world.joint.get_param("/rate") == 2
    assert await world.joint.has_param("/rate")
    assert await world.joint.search_param("rate") == "/rate"
    await first.set_param("/rate", 1)
    assert await world.joint.get_param("/rate") == 1
    await until(lambda: seen == [2, 1])
    await second.set_param("/rate", 3)
    await world.joint.set_param("/new", 7)
    await second.set_param("/there", 7)
    await world.joint.set_param("/there", 8)
    assert await second.get_param("/there") == 8
    assert (await first.list_params(), await second.list_params()) == (["/new", "/rate"], ["/rate", "/there"])
    assert await world.joint.list_params() == ["/new", "/rate", "/there"]
    await world.joint.delete_param("/rate")
    await until(lambda: seen == [2, 1, 3])
    await world.joint.delete_param("/rate")
    await until(lambda: seen == [2, 1, 3, None])
    with pytest.raises(UnknownNameError):
        await world.joint.delete_param("/rate")
    await watch.close()
    await world.joint.close()


async def test_both_graphs_are_seen_as_one() -> None:
    world = await make_world()
    changes = world.joint.changes()
    await anext(changes)
    await world.others[0].advertise("/chat", STRING)
    await world.others[1].subscribe("/chat", STRING, Inbox().store)
    await world.others[1].advertise_service("/switch", SET_BOOL, answering(""))
    while "/switch" not in (snapshot := await asyncio.wait_for(anext(changes), 60)).services:
        pass
    assert snapshot == await world.joint.snapshot()
    assert snapshot.nodes == ("/board", "/other")
    chat = snapshot.topics["/chat"]
    assert (chat.type, chat.publishers, chat.subscribers) == ("std_msgs/String", ("/other",), ("/other",))
    world.joint.log(Level.WARN, "hot")
    assert [network.logs[-1].text for network in world.networks] == ["hot", "hot"]
    ended = asyncio.ensure_future(anext(changes, None))
    await world.joint.close()
    assert await asyncio.wait_for(ended, 60) is None
    assert all(network.snapshot().nodes == ("/other",) for network in world.networks)


async def test_it_leaves_when_the_graph_shuts_it_down() -> None:
    world = await make_world()
    closed = asyncio.ensure_future(world.joint.wait_closed())
    await world.networks[1].join("/board")
    assert await asyncio.wait_for(closed, 60) == "new node registered with same name"
    await world.joint.close()
    assert await world.joint.wait_closed() == "new node registered with same name"
    with pytest.raises(GraphError, match="has left the graph"):
        await world.joint.advertise("/chat", STRING)
    assert "/board" not in world.networks[0].snapshot().nodes


class ClosableGraph:
    """A `JoinGraph` that refuses every node until it is open."""

    def __init__(self, network: MemoryNetwork) -> None:
        self._network = network
        self.is_open = False
        self.attempts = 0

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        self.attempts += 1
        if not self.is_open:
            raise MasterUnreachableError("not open yet")
        return await self._network.join(node_name, namespace=namespace, remappings=remappings)


@pytest.mark.parametrize("position", [0, 1])
async def test_a_graph_that_joins_late_gets_all_handles(
    position: int, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.graph.joint_handle.FIRST_RETRY_S", 0.01)
    early, late = MemoryNetwork(), MemoryNetwork()
    closable = ClosableGraph(late)
    joins: list[Any] = [early.join]
    joins.insert(position, closable)
    joint = await JointJoin(joins)("/board")
    assert "not open yet" in caplog.text
    seen: list[ParamValue] = []
    inbox, mine = Inbox(), Inbox()
    publisher = await joint.advertise("/map", STRING, latch=True)
    publisher.publish_raw([string("old"), string("new")])
    subscriber = await joint.subscribe("/back", STRING, mine.store)
    gone = await joint.advertise("/gone", STRING)
    await gone.close()
    await joint.advertise_service("/switch", SET_BOOL, answering("mine"))
    await joint.watch_param("/rate", seen.append)
    subscriber.pause()
    changes = joint.changes()
    await anext(changes)
    other = await late.join("/other")
    await other.set_param("/rate", 1)
    back = await other.advertise("/back", STRING, latch=True)
    back.publish_raw([string("back")])
    await other.subscribe("/map", STRING, inbox.store)
    closable.is_open = True
    await until(lambda: inbox.payloads == [string("new")])
    await until(lambda: seen == [None, 1])
    assert await other.call_service("/switch", SET_BOOL, TRUE) == answer("mine")
    assert "/gone" not in late.snapshot().topics
    while "/other" not in (await asyncio.wait_for(anext(changes), 60)).nodes:
        pass
    assert mine.payloads == []
    subscriber.resume()
    await until(lambda: mine.payloads == [string("back")])
    await joint.close()
    assert "/board" not in late.snapshot().nodes


async def test_after_the_end_a_late_graph_is_not_awaited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.graph.joint_handle.FIRST_RETRY_S", 0.01)
    closable = ClosableGraph(MemoryNetwork())
    joint = await JointJoin([MemoryNetwork().join, closable])("/board")
    await until(lambda: closable.attempts > 2)
    await joint.close()
    attempts = closable.attempts
    await asyncio.sleep(0.03)
    assert closable.attempts == attempts


async def test_no_graph_at_all_is_an_error() -> None:
    with pytest.raises(MasterUnreachableError, match="not open yet"):
        await JointJoin([ClosableGraph(MemoryNetwork()), ClosableGraph(MemoryNetwork())])("/board")
    network = MemoryNetwork()
    with pytest.raises(InvalidNameError):
        await JointJoin([network.join, ClosableGraph(MemoryNetwork())])("no name")
    assert network.snapshot().nodes == ()


class MoodyGraph(MemoryGraph):
    """Refuses to publish with `fault`, or hangs."""

    fault: Exception | None = None
    hangs = False
    attempts = 0

    async def advertise(self, *args: Any, **kwargs: Any) -> Any:
        self.attempts += 1
        if self.fault is not None:
            raise self.fault
        if self.hangs:
            await asyncio.Event().wait()
        return await super().advertise(*args, **kwargs)


async def make_moody() -> tuple[JointGraph, MoodyGraph, MemoryNetwork]:
    network, moody_network = MemoryNetwork(), MemoryNetwork()
    moody = MoodyGraph(moody_network, "/board", "/", {})
    return JointGraph([moody, await network.join("/board")]), moody, moody_network


async def test_a_refusal_for_now_is_tried_again(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_handle, "FIRST_RETRY_S", 0.01)
    joint, moody, network = await make_moody()
    moody.fault = MasterUnreachableError("away")
    publisher = await joint.advertise("/chat", STRING)
    assert "/board: /chat is not in every graph yet: away" in caplog.text
    await until(lambda: moody.attempts > 2)
    moody.fault = None
    await until(lambda: "/chat" in network.snapshot().topics)
    moody.fault = MasterUnreachableError("away")
    other = await joint.advertise("/other", STRING)
    await until(lambda: moody.attempts > 5)
    await other.close()
    attempts = moody.attempts
    await asyncio.sleep(0.03)
    assert moody.attempts == attempts
    await publisher.close()
    await joint.close()


async def test_a_permanent_refusal_is_reported_once(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_handle, "FIRST_RETRY_S", 0.001)
    joint, moody, _ = await make_moody()
    moody.fault = MasterUnreachableError("away")
    await joint.advertise("/chat", STRING)
    moody.fault = UnknownTypeError("never heard of it")
    await until(lambda: "never heard of it" in caplog.text)
    attempts = moody.attempts
    await joint.advertise("/other", STRING)
    await asyncio.sleep(0.02)
    assert moody.attempts == attempts + 1
    assert "/board: /other is not in every graph: never heard of it" in caplog.text
    await joint.close()


async def test_a_graph_that_hangs_does_not_delay_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joint_handle, "SLOW_GRAPH_S", 0.01)
    joint, moody, _ = await make_moody()
    moody.hangs = True
    publisher = await asyncio.wait_for(joint.advertise("/chat", STRING), 60)
    assert len(publisher.parts) == 1
    await asyncio.wait_for(publisher.close(), 60)
    await asyncio.wait_for(joint.close(), 60)


async def test_a_handle_that_all_graphs_refuse_is_refused() -> None:
    joint = JointGraph([BrokenGraph("/board"), BrokenGraph("/board")])
    with pytest.raises(MasterUnreachableError):
        await joint.advertise("/chat", BOOL)
    with pytest.raises(MasterUnreachableError):
        await joint.snapshot()
    with pytest.raises(MasterUnreachableError):
        await joint.get_param("/rate")
    await joint.close()


class ListingGraph(MemoryGraph):
    """A graph that lists clients, as ROS 2 does."""

    listed = 0

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        self.listed += 1

        async def withdraw() -> None:
            self.listed -= 1

        return ListedClient(withdraw)


async def test_clients_are_listed_where_the_graph_lists_them() -> None:
    first, second, late = [await MemoryNetwork().join("/board") for _ in range(3)]
    second.__class__ = late.__class__ = ListingGraph
    joint = JointGraph([first, second])
    assert isinstance(joint, ListsClients)
    client = await joint.list_client("switch", SET_BOOL)
    await joint.add(late, 2)
    graphs = [cast(ListingGraph, graph) for graph in (second, late)]
    assert [graph.listed for graph in graphs] == [1, 1]
    await client.close()
    await client.close()
    assert [graph.listed for graph in graphs] == [0, 0]
    await joint.close()


async def test_messages_of_relays_and_boards_of_other_programs_arrive_once() -> None:
    networks = [MemoryNetwork(), MemoryNetwork()]
    joins = [JointJoin([network.join for network in networks]) for _ in range(2)]
    board, other = await joins[0]("/board"), await joins[1]("/other")
    inbox = Inbox()
    await board.subscribe("/chat", STRING, inbox.store)
    relays = [await network.join("/relay") for network in networks]
    mark = new_relay_mark()
    for relay in relays:
        await relay.advertise(mark, MARK_TYPE)
    await until(lambda: "/relay" in joins[0]._relays and "/other" in joins[0]._joint_nodes)
    talker = await (await networks[0].join("/talker")).advertise("/chat", STRING)
    copy = await relays[1].advertise("/chat", STRING)
    mine = await other.advertise("/chat", STRING)
    talker.publish_raw([string("hello")])
    copy.publish_raw([string("hello")])
    mine.publish_raw([string("me too")])
    await until(lambda: len(inbox.payloads) >= 2)
    await asyncio.sleep(0.02)
    assert sorted(inbox.payloads) == [string("hello"), string("me too")]
    # Another node of the program continues to search when one leaves, and detects that the relay leaves.
    third = await joins[0]("/third")
    await board.close()
    for relay in relays:
        await relay.close()
    await until(lambda: not joins[0]._relays)
    for graph in (other, third):
        await graph.close()
