from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from loop_watch import LoopWatch
from rostether.bridge.board_node import BoardNode
from rostether.bridge.outbound.held_events import MAX_HELD_BYTES, HeldEvents
from rostether.bridge.session import Session
from rostether.msgdef.md5sum import message_md5sum
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.registry import Registry
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import (
    HostEvent,
    MessagesReceived,
    NegotiationSettled,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
)
from rostether.rosserial.packets import TopicInfo
from rostether.serde.store import TypeStore
from rostether.transports.memory import memory_pair
from unit.bridge.nodes import World, publisher
from unit.bridge.raw_board import RawBoard
from waiting import until

SETTLED = NegotiationSettled()
OWN = "my_robot/Wheel"
OWN_TEXT = "uint32 ticks\n"
OWN_MD5SUM = message_md5sum(parse_message(OWN_TEXT, package="my_robot", name="Wheel"), Registry().message)


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a package among folders of other things."""
    package = tmp_path / "robots" / "my_robot"
    (package / "msg").mkdir(parents=True)
    (package / "msg" / "Wheel.msg").write_text(OWN_TEXT)
    (package / "package.xml").write_text("<package><name>my_robot</name></package>")
    for number in range(20):
        (tmp_path / f"other{number}").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
async def world() -> AsyncIterator[World]:
    world = World()
    await world.open()
    yield world


def announced(type_name: str = OWN, md5sum: str = OWN_MD5SUM) -> TopicAnnounced:
    return TopicAnnounced(TopicRole.PUBLISHER, TopicInfo(125, "wheel", type_name, md5sum, 280))


def fail(error: Exception) -> None:
    raise error


async def test_a_type_is_searched_while_the_loop_goes_on_and_no_message_is_lost(
    workspace: Path, world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    store = TypeStore(Registry.from_environment(environ={}))
    node = BoardNode(world.board, store, world.reporter, asyncio.get_running_loop().time)
    ours, theirs = memory_pair()
    board = RawBoard(theirs, (ids.PUBLISHER, announced().info))
    session = Session(ours, node)
    session.start()
    await until(lambda: session._held._wait is not None, "a search")
    for ticks in range(3):
        board.send(125, struct.pack("<I", ticks))
    await until(lambda: session._held._wait is None, "the end of the search")
    received: list[bytes] = []
    assert node.endpoints.announced_topics() == ["wheel"]
    await world.peer.subscribe("/wheel", store.registry.message_type(OWN), received.extend)
    board.send(125, struct.pack("<I", 7))
    await until(lambda: received, "a message")
    assert watch.folders > 20
    assert watch.held == 0
    assert [endpoint.message_count for _, endpoint in node.endpoints] == [4]
    await session.stop()
    await node.close()


async def test_a_search_is_only_for_unknown_definitions(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    held = HeldEvents(Registry.from_environment(environ={}), lambda _: None, lambda _: None)
    assert not held.hold_back(publisher())
    assert not held.hold_back(SETTLED)
    assert (watch.folders, watch.held) == (0, 0)


@pytest.mark.parametrize("event", [announced(), announced("std_msgs/String", "0" * 32)])
async def test_events_wait_in_their_order(workspace: Path, event: TopicAnnounced) -> None:
    handled: list[HostEvent] = []
    held = HeldEvents(Registry.from_environment(environ={}), handled.append, fail)
    messages = MessagesReceived(125, [b"x"])
    assert held.hold_back(event)
    assert held.keep(messages)
    assert held.hold_back(publisher("other"))
    assert held.hold_back(SETTLED)
    assert not held.hold_back(TimeRequested())
    assert not held.keep(MessagesReceived(125, [bytes(MAX_HELD_BYTES)]))
    await until(lambda: handled, "the end of the search")
    assert handled == [event, messages, publisher("other"), SETTLED]
    assert not held.hold_back(event)


async def test_held_events_end_with_their_connection(workspace: Path) -> None:
    handled: list[HostEvent] = []
    registry = Registry.from_environment(environ={})
    held = HeldEvents(registry, handled.append, fail)
    assert held.hold_back(announced())
    held.drop()
    await until(lambda: registry.can_answer(registry.packages), "the end of the search")
    await asyncio.sleep(0)
    assert handled == []


async def test_a_defect_ends_with_its_session(workspace: Path) -> None:
    faults: list[Exception] = []

    def handle(_: HostEvent) -> None:
        raise ZeroDivisionError

    held = HeldEvents(Registry.from_environment(environ={}), handle, faults.append)
    assert held.hold_back(announced())
    await until(lambda: faults, "the end of the search")
    assert isinstance(faults[0], ZeroDivisionError)
