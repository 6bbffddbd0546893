"""Boards in both graphs, and several relays: nothing is relayed twice."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from contract.graphs import ADD_DIAGNOSTICS, EMPTY, SET_BOOL, STRING, Inbox, answer_set_bool, string
from rostether.graph.joint_marks import MARK_TYPE, new_joint_mark, new_relay_mark
from rostether.graph.memory_network import MemoryGraph
from rostether.graph.ports import Snapshot
from rostether.relay import relay as relay_module
from rostether.relay.relay_filter import ServiceFilter, TopicFilter
from unit.relay.relay_world import World
from waiting import until

SERVICE_TYPES = {each.name: each for each in (SET_BOOL, ADD_DIAGNOSTICS, EMPTY)}


async def marked(world: World, name: str, mark: str) -> list[MemoryGraph]:
    """Join both graphs as a node that has a mark."""
    graphs = [await network.join(name) for network in world.networks]
    for graph in graphs:
        await graph.advertise(mark, MARK_TYPE)
    return graphs


async def test_a_board_in_both_graphs_is_skipped(world: World) -> None:
    boards = await marked(world, "/board", new_joint_mark())
    mine = [await board.advertise("/chat", STRING) for board in boards]
    inbox = Inbox()
    await world.two.subscribe("/chat", STRING, inbox.store)
    async with world.relaying(TopicFilter("/*"), services=(ServiceFilter("/*"),)):
        await until(lambda: world.lines)
        assert world.lines == ["/board is a node of both graphs: its messages are not relayed"]
        await asyncio.sleep(0.05)
        assert not world.relayed
        # Messages of other publishers are relayed, without those of the board.
        talker = await world.one.advertise("/chat", STRING)
        await until(lambda: world.carries("/chat", 1) and talker.subscriber_count)
        for publisher in (*mine, talker):
            publisher.publish_raw([string("hello" if publisher is talker else "board")])
        await until(lambda: len(inbox.payloads) == 2)
        await asyncio.sleep(0.02)
        assert sorted(inbox.payloads) == sorted([string("hello"), string("board")])


async def test_nodes_with_the_same_name_in_both_graphs_are_two_nodes(world: World) -> None:
    talkers = [await (await network.join("/talker")).advertise("/chat", STRING) for network in world.networks]
    async with world.relaying(TopicFilter("/chat")):
        await until(lambda: all(talker.subscriber_count for talker in talkers))


async def test_topics_and_services_of_another_relay_are_not_relayed(world: World) -> None:
    # It has the mark of a relay that started later, but it already relays the topic.
    others = await marked(world, "/other_relay", new_relay_mark().replace("relay_", "relay_f"))
    await world.one.advertise("/chat", STRING)
    theirs = await others[1].advertise("/chat", STRING)
    await world.one.advertise_service("/switch", SET_BOOL, answer_set_bool)
    served = await others[1].advertise_service("/switch", SET_BOOL, answer_set_bool)
    async with world.relaying(TopicFilter("/*"), services=(ServiceFilter("/*"),)):
        for what in ("/chat", "service /switch"):
            reason = "the relay /other_relay already relays it"
            line = f"not relaying {what} from one to two: {reason}"
            await until(lambda: line in world.lines)  # noqa: B023 - awaited at once
        assert not world.relayed
        await theirs.close()
        await served.close()
        await until(lambda: world.carries("/chat", 1))
        await until(lambda: len(world.relayed) == 2)


async def test_of_two_active_relays_the_younger_one_stops(world: World) -> None:
    await world.one.advertise("/chat", STRING)
    async with world.relaying(TopicFilter("/*")):
        await until(lambda: world.carries("/chat", 1))
        younger = await marked(world, "/younger", new_relay_mark().replace("relay_", "relay_f"))
        await younger[1].advertise("/chat", STRING)
        await until(lambda: any("/younger" in line for line in world.lines))
        await asyncio.sleep(0.02)
        assert world.carries("/chat", 1)
        older = await marked(world, "/older", new_relay_mark().replace("relay_1", "relay_0"))
        await older[1].advertise("/chat", STRING)
        await until(lambda: not world.carries("/chat", 1))


async def test_a_younger_relay_waits_for_older_ones(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relay_module, "OLDER_RELAY_WAIT_S", 0.5)
    others = await marked(world, "/older", new_relay_mark())
    async with world.relaying(TopicFilter("/*")):
        await until(lambda: any("/older" in line for line in world.lines))
        await world.one.advertise("/chat", STRING)
        await asyncio.sleep(0.01)
        assert not world.relayed
        await others[1].advertise("/chat", STRING)
        await until(lambda: any("/older already relays it" in line for line in world.lines))
        await asyncio.sleep(0.6)
        assert not world.relayed
        # The older relay does not choose this topic.
        await world.one.advertise("/more", STRING)
        await until(lambda: world.carries("/more", 1))


async def test_a_killed_relay_is_forgotten(world: World) -> None:
    killed = await marked(world, "/killed", new_relay_mark())
    await world.two.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await killed[0].advertise_service("/switch", SET_BOOL, answer_set_bool)
    asked: list[str] = []
    is_gone = False

    async def forget(name: str) -> bool:
        asked.append(name)
        return is_gone

    async with world.relaying(services=(ServiceFilter("/*"),), forget_if_gone=forget):
        await until(lambda: any("relays it" in line for line in world.lines))
        assert not world.relayed
        is_gone = True
        # Its registrations in both graphs are still listed.
        await until(lambda: "the relay /killed was killed: removed its registrations" in world.lines)
        await until(lambda: world.relayed)
        assert world.networks[0].snapshot().services["/switch"].providers == ("/relay",)
    assert set(asked) == {"/killed"}


async def test_a_relay_that_was_killed_before_is_not_a_source(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(relay_module, "DISCOVERY_S", 1.0)
    killed = await marked(world, "/killed", new_relay_mark())
    await killed[0].advertise_service("/switch", SET_BOOL, answer_set_bool)
    # Only the first graph keeps the registrations of nodes that were killed.
    await killed[1].close()
    await world.one.advertise("/chat", STRING)
    changes = world.relays[0].changes

    async def slowly() -> AsyncIterator[Snapshot]:
        # A ROS 1 master answers after the tasks of the relay have started.
        await asyncio.sleep(0.02)
        async for snapshot in changes():
            yield snapshot

    monkeypatch.setattr(world.relays[0], "changes", slowly)

    async def forget(_: str) -> bool:
        return True

    async with world.relaying(TopicFilter("/chat"), services=(ServiceFilter("/*"),), forget_if_gone=forget):
        await until(lambda: world.carries("/chat", 1))
        assert "the relay /killed was killed: removed its registrations" in world.lines
        assert not any("/switch" in line for line in world.lines)
