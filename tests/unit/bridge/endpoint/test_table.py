from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping
from typing import Any

import pytest
from msgspec.structs import replace

from rostether.bridge.endpoint.factory import EndpointFactory
from rostether.bridge.endpoint.table import EndpointTable
from rostether.bridge.findings.endpoint_findings import EndpointFindings
from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.oversize import Oversizes
from rostether.bridge.settings import DEFAULT_SETTINGS
from rostether.errors import GraphError
from rostether.graph.memory_endpoints import MemoryPublisher
from rostether.graph.memory_network import MemoryGraph
from rostether.msgdef.interface import MessageType
from rostether.rosserial.events import (
    ServiceRole,
    ServiceWithdrawn,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, publisher, service, subscriber, text, topic_info
from waiting import until


class Table(World):
    """A world with the board's endpoint table."""

    table: EndpointTable

    async def open(self) -> Table:
        await super().open()
        factory = EndpointFactory(self.board, STORE, self.notices, DEFAULT_SETTINGS)
        self.table = EndpointTable(factory, self.notices)
        return self

    def publishers(self, topic: str) -> tuple[str, ...]:
        info = self.network.snapshot().topics.get(topic)
        return info.publishers if info is not None else ()

    def subscribers(self, topic: str) -> tuple[str, ...]:
        info = self.network.snapshot().topics.get(topic)
        return info.subscribers if info is not None else ()

    async def advertised(self, topic: str) -> None:
        await until(lambda: "/board" in self.publishers(topic), f"{topic} to be advertised")

    async def has_type(self, topic: str, type_name: str) -> None:
        # Between the old type and the new one, the topic is not in the graph.
        def is_there() -> bool:
            found = self.network.snapshot().topics.get(topic)
            return found is not None and found.type == type_name

        await until(is_there, f"{topic} to have the type {type_name}")

    async def withdrawn(self, topic: str) -> None:
        await until(lambda: "/board" not in self.publishers(topic), f"{topic} to be withdrawn")


@pytest.fixture
async def world() -> Table:
    return await Table().open()


async def test_a_board_may_publish_and_subscribe_one_name(world: Table) -> None:
    line = FakeLine()
    assert world.table.announce_topic(publisher("loop"), line)
    assert world.table.announce_topic(subscriber("loop"), line)
    await world.advertised("/loop")
    await until(lambda: "/board" in world.subscribers("/loop"), "the subscription")


async def test_two_ids_of_one_topic_both_count(world: Table) -> None:
    received, line = await world.listen("/chatter"), FakeLine()
    world.table.announce_topic(publisher(topic_id=125), line)
    world.table.announce_topic(publisher(topic_id=126), line)
    line.receivers[125]([text("a")])
    line.receivers[126]([text("b")])
    await until(lambda: len(received) == 2, "both messages")


async def test_an_unknown_type_is_one_line_and_stops_no_other_topic(world: Table) -> None:
    line = FakeLine()
    info = topic_info("odd", md5sum="0" * 32)
    for _ in range(3):
        unknown = TopicAnnounced(TopicRole.PUBLISHER, replace(info, message_type="my_robot/Odd"))
        assert not world.table.announce_topic(unknown, line)
    assert world.table.announce_topic(publisher(topic_id=126), line)
    await world.advertised("/chatter")
    (reported,) = world.reporter.having("odd")
    assert "my_robot" in reported
    assert "--msg-path" in reported


async def test_another_definition_is_one_line_with_both_md5sums(world: Table) -> None:
    line = FakeLine()
    theirs = "f" * 32
    info = topic_info("chatter", md5sum=theirs)
    assert not world.table.announce_topic(TopicAnnounced(TopicRole.PUBLISHER, info), line)
    (reported,) = world.reporter.texts
    assert theirs in reported
    assert STORE.registry.message_type("std_msgs/String").md5sum in reported
    assert world.publishers("/chatter") == ()


async def test_another_definition_of_a_service_is_reported_by_its_half(world: Table) -> None:
    switch = service(ServiceRole.SERVER)
    switch = replace(switch, response=replace(switch.response, md5sum="f" * 32))
    assert not world.table.announce_service(switch, FakeLine())
    assert "SetBoolResponse" in world.reporter.texts[0]


async def test_an_illegal_name_is_one_line(world: Table) -> None:
    assert not world.table.announce_topic(publisher("1st"), FakeLine())
    assert "1st" in world.reporter.texts[0]


async def test_a_board_that_reconnects_has_its_topics_unchanged(world: Table) -> None:
    received, old, new = await world.listen("/chatter"), FakeLine(), FakeLine()
    connections: list[Mapping[str, str]] = []
    await world.peer.subscribe(
        "/chatter",
        STORE.registry.message_type("std_msgs/String"),
        lambda _: None,
        on_connection=connections.append,
    )
    world.table.announce_topic(publisher(topic_id=125), old)
    await world.advertised("/chatter")
    world.table.detach_all()
    assert world.publishers("/chatter") == ("/board",)
    world.table.announce_topic(publisher(topic_id=130), new)
    world.table.settle()
    new.receivers[130]([text("back")])
    await until(lambda: received, "the message")
    assert len(connections) == 1, "the subscriber was not connected again"
    assert [endpoint.info for _, endpoint in world.table] == [topic_info(topic_id=130)]


async def test_an_endpoint_that_is_not_announced_again_leaves_the_graph(world: Table) -> None:
    old, new = FakeLine(), FakeLine()
    world.table.announce_topic(publisher("kept"), old)
    world.table.announce_topic(publisher("gone", topic_id=126), old)
    await world.advertised("/gone")
    world.table.detach_all()
    world.table.announce_topic(publisher("kept"), new)
    assert world.publishers("/gone") == ("/board",)
    world.table.settle()
    await world.withdrawn("/gone")
    assert world.publishers("/kept") == ("/board",)


async def test_another_type_replaces_the_topic(world: Table) -> None:
    line = FakeLine()
    world.table.announce_topic(publisher("level"), line)
    await world.advertised("/level")
    world.table.detach_all()
    world.table.announce_topic(publisher("level", "std_msgs/UInt16"), line)
    await world.has_type("/level", "std_msgs/UInt16")
    assert len(list(world.table)) == 1


async def test_a_sketch_flashed_again_gives_a_name_another_type_under_another_id(world: Table) -> None:
    received, line = await world.listen("/level", "std_msgs/UInt16"), FakeLine()
    world.table.announce_topic(publisher("gone", topic_id=125), line)
    world.table.announce_topic(publisher("level", topic_id=126), line)
    await world.advertised("/level")
    # The events of a reset: the changed ids, and later the endpoints that were not announced again.
    world.table.withdraw(TopicWithdrawn(TopicRole.PUBLISHER, topic_info("gone", topic_id=125)))
    world.table.announce_topic(publisher("level", "std_msgs/UInt16", topic_id=125), line)
    await asyncio.sleep(0.01)
    world.table.withdraw(TopicWithdrawn(TopicRole.PUBLISHER, topic_info("level", topic_id=126)))
    world.table.settle()
    line.receivers[125]([b"\x07\x00"])
    await until(lambda: received == [b"\x07\x00"], "the message of the new type")
    assert world.reporter.texts == []
    assert set(line.receivers) == {125}


async def test_two_ids_of_a_lost_board_both_give_way_to_another_type(world: Table) -> None:
    old, new = FakeLine(), FakeLine()
    world.table.announce_topic(publisher("level", topic_id=125), old)
    world.table.announce_topic(publisher("level", topic_id=126), old)
    await world.advertised("/level")
    world.table.detach_all()
    world.table.announce_topic(publisher("level", "std_msgs/UInt16", topic_id=125), new)
    await world.has_type("/level", "std_msgs/UInt16")
    assert world.reporter.texts == []
    assert len(list(world.table)) == 1


async def test_one_name_with_two_types_is_one_line_and_the_last_is_served(world: Table) -> None:
    line = FakeLine()
    # In one chunk: the first endpoint is not completely in the graph when it must leave it.
    world.table.announce_topic(publisher("level", topic_id=125), line)
    world.table.announce_topic(publisher("level", "std_msgs/UInt16", topic_id=126), line)
    world.table.settle()
    await world.advertised("/level")
    assert world.network.snapshot().topics["/level"].type == "std_msgs/UInt16"
    (reported,) = world.reporter.texts
    assert "level with two types" in reported


async def test_a_name_used_by_another_spelling_is_bridged_after_that_is_withdrawn(world: Table) -> None:
    received, line = await world.listen("/level", "std_msgs/UInt16"), FakeLine()
    world.table.announce_topic(publisher("/level", topic_id=126), line)
    await world.advertised("/level")
    world.table.announce_topic(publisher("level", "std_msgs/UInt16", topic_id=125), line)
    await until(lambda: world.reporter.having("level is not bridged"), "the refusal")
    findings = EndpointFindings(world.table, STORE)
    (finding,) = findings.find(0.0, -math.inf, Oversizes())
    assert finding.seen.startswith("level is not bridged: ")
    assert finding.code is Code.NOT_BRIDGED
    world.table.withdraw(TopicWithdrawn(TopicRole.PUBLISHER, topic_info("/level", topic_id=126)))
    line.receivers[125]([b"\x07\x00"])
    await until(lambda: received == [b"\x07\x00"], "the message of the new type")
    await until(lambda: world.reporter.texts[-1] == "level is bridged now", "the report")
    assert findings.find(0.0, -math.inf, Oversizes()) == []


async def test_findings_keep_nothing_of_withdrawn_topics(world: Table) -> None:
    findings, info = EndpointFindings(world.table, STORE), topic_info("/level")
    world.table.announce_topic(TopicAnnounced(TopicRole.SUBSCRIBER, info), FakeLine())
    findings.find(0.0, -math.inf, Oversizes())
    assert len(findings._losses) == 1
    world.table.withdraw(TopicWithdrawn(TopicRole.SUBSCRIBER, info))
    await until(lambda: not findings._losses, "the end of the endpoint")


async def test_the_device_withdraws_a_topic(world: Table) -> None:
    line = FakeLine()
    world.table.announce_topic(publisher(), line)
    await world.advertised("/chatter")
    world.table.withdraw(TopicWithdrawn(TopicRole.PUBLISHER, topic_info()))
    await world.withdrawn("/chatter")
    assert line.receivers == {}


async def test_services_come_and_go(world: Table) -> None:
    line = FakeLine()
    served, called = (
        service(ServiceRole.SERVER, "served"),
        service(ServiceRole.CLIENT, "called", first_id=120),
    )
    assert world.table.announce_service(served, line)
    assert world.table.announce_service(called, line)
    await until(lambda: "/served" in world.network.snapshot().services, "the service")
    assert set(line.receivers) == {111, 120}
    for event in (served, called):
        world.table.withdraw(
            ServiceWithdrawn(event.role, event.name, event.type, event.request, event.response)
        )
    await until(lambda: not world.network.snapshot().services, "the service to go")
    assert line.receivers == {}


async def test_a_service_that_comes_back_under_other_ids_is_the_same(world: Table) -> None:
    old, new = FakeLine(), FakeLine()
    world.table.announce_service(service(ServiceRole.SERVER), old)
    await until(lambda: "/switch" in world.network.snapshot().services, "the service")
    world.table.detach_all()
    world.table.announce_service(service(ServiceRole.SERVER, first_id=120), new)
    assert set(new.receivers) == {121}
    assert len(list(world.table)) == 1


async def test_a_service_stays_when_its_old_ids_are_withdrawn(world: Table) -> None:
    line = FakeLine()
    old = service(ServiceRole.SERVER, first_id=110)
    world.table.announce_service(old, line)
    await until(lambda: "/switch" in world.network.snapshot().services, "the service")
    world.table.announce_service(service(ServiceRole.SERVER, first_id=120), line)
    world.table.withdraw(ServiceWithdrawn(old.role, old.name, old.type, old.request, old.response))
    world.table.settle()
    assert set(line.receivers) == {121}
    assert len(list(world.table)) == 1


async def test_a_reset_board_gets_latched_messages_again(world: Table) -> None:
    latched = await world.peer.advertise("/led", STORE.registry.message_type("std_msgs/String"), latch=True)
    latched.publish_raw([text("config")])
    line = FakeLine()
    world.table.announce_topic(subscriber("led"), line)
    await until(lambda: line.transport.written.count(b"config") == 1, "the latched message")
    world.table.renew_latched()
    await until(lambda: line.transport.written.count(b"config") == 2, "the latched message again")
    world.table.detach_all()
    again = FakeLine()
    world.table.announce_topic(subscriber("led"), again)
    await until(lambda: again.transport.written.count(b"config") == 1, "the latched message after the loss")


class RefusingGraph:
    """Forwards calls to a real node, but refuses to advertise a few times."""

    def __init__(self, graph: MemoryGraph, refusals: int) -> None:
        self._graph = graph
        self.refusals = refusals

    def __getattr__(self, name: str) -> Any:
        return getattr(self._graph, name)

    async def advertise(self, topic: str, message_type: MessageType, **options: Any) -> MemoryPublisher:
        if self.refusals:
            self.refusals -= 1
            raise GraphError("the master said no")
        return await self._graph.advertise(topic, message_type, **options)


async def test_a_graph_that_refuses_is_asked_again(world: Table) -> None:
    received, line = await world.listen("/chatter"), FakeLine()
    refusing: Any = RefusingGraph(world.board, 2)
    factory = EndpointFactory(refusing, STORE, world.notices, DEFAULT_SETTINGS)
    table = EndpointTable(factory, world.notices)
    table.announce_topic(publisher(), line)
    line.receivers[125]([text("early")])
    await until(lambda: received, "the message")
    assert received == [text("early")]
    assert len(world.reporter.having("the master said no")) == 1


async def test_a_topic_withdrawn_while_the_graph_refuses_it_is_not_retried(world: Table) -> None:
    refusing: Any = RefusingGraph(world.board, 10_000)
    table = EndpointTable(EndpointFactory(refusing, STORE, world.notices, DEFAULT_SETTINGS), world.notices)
    table.announce_topic(publisher(), FakeLine())
    await until(lambda: world.reporter.texts, "the refusal")
    asked = refusing.refusals
    await asyncio.wait_for(table.close(), 60.0)
    assert refusing.refusals >= asked - 1


async def test_closing_removes_all_endpoints_from_the_graph(world: Table) -> None:
    line = FakeLine()
    world.table.announce_topic(publisher(), line)
    world.table.announce_topic(subscriber("led"), line)
    world.table.announce_service(service(ServiceRole.SERVER), line)
    await world.advertised("/chatter")
    await world.table.close()
    snapshot = world.network.snapshot()
    assert world.publishers("/chatter") == ()
    assert world.subscribers("/led") == ()
    assert snapshot.services == {}
    assert line.receivers == {}
