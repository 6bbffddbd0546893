from __future__ import annotations

import asyncio

from rostether.bridge.board_node import BoardNode
from rostether.bridge.health.diagnostics import view_board
from rostether.bridge.session import Session
from rostether.rosserial.events import ServiceRole
from unit.bridge.doubles import FakeLine, FakeTransport
from unit.bridge.nodes import STORE, World, publisher, service, subscriber, text


async def test_every_endpoint_is_shown_with_its_counts() -> None:
    world = await World().open()
    node = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time)
    line = FakeLine()
    node.endpoints.announce_topic(publisher(), line)
    node.endpoints.announce_topic(subscriber("led"), line)
    node.endpoints.announce_service(service(ServiceRole.SERVER, "served"), line)
    node.endpoints.announce_service(service(ServiceRole.CLIENT, "called", first_id=120), line)
    line.receivers[125]([text("a"), b"bad", text("b")])
    view = view_board(node, None)
    shown = [(each.role, each.name, each.type, each.topic_id) for each in view.endpoints]
    assert shown == [
        ("publisher", "chatter", "std_msgs/String", 125),
        ("subscriber", "led", "std_msgs/String", 100),
        ("service server", "served", "std_srvs/SetBool", 110),
        ("service client", "called", "std_srvs/SetBool", 120),
    ]
    assert (view.endpoints[0].message_count, view.endpoints[0].misfit_count) == (2, 1)
    assert all(each.is_attached for each in view.endpoints)
    assert (view.node, view.is_connected, view.peer) == ("/board", False, "")
    node.endpoints.detach_all()
    assert not any(each.is_attached for each in view_board(node, None).endpoints)
    await node.close()


async def test_a_connection_is_shown_with_its_figures() -> None:
    world = await World().open()
    node = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time)
    session = Session(FakeTransport(), node)
    session.start()
    session.data_received(b"noise that is no frame")
    view = view_board(node, session)
    assert (view.peer, view.is_connected, view.is_settled) == ("fake board", True, False)
    assert view.received_bytes == 22
    assert view.sent_bytes > 0
    session.connection_lost(None)
    assert not view_board(node, session).is_connected
    await node.close()


async def test_a_closed_node_logs_to_users_only() -> None:
    world = await World().open()
    node = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time)
    await node.close()
    await node.close()
    assert world.network.nodes.keys() == {"/peer"}
    assert node.notices.to_graph is None
