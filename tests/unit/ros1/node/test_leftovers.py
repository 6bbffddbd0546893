"""Registrations of nodes that ended without unregistering."""

from __future__ import annotations

import asyncio

from contract.graphs import SET_BOOL, STRING, answer_set_bool
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.leftovers import Leftovers
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node import join_ros1
from rostether.transports.sockets import close_servers


async def test_only_nodes_that_have_ended_are_forgotten() -> None:
    master = await MasterServer.start(port=0)
    environment = RosEnvironment.read({}).with_master(master.uri)
    node = await join_ros1("/alive", environment=environment)
    await node.advertise("/chat", STRING)
    await node.advertise_service("/switch", SET_BOOL, answer_set_bool)
    # A port that was just free: no program answers there.
    listener = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0)
    uri = f"http://127.0.0.1:{listener.sockets[0].getsockname()[1]}/"
    killed = MasterClient(master.uri, "/killed")
    await killed.register_publisher("/chat", STRING.name, uri)
    await killed.register_subscriber("/back", STRING.name, uri)
    await killed.register_service("/pull", "rosrpc://127.0.0.1:1", uri)
    leftovers = Leftovers(master.uri, "/relay")
    assert not await leftovers.forget_if_gone("/alive")
    assert not await leftovers.forget_if_gone("/unknown")
    # A node with an invalid answer may still be starting; after three of them it counts as gone.
    assert not await leftovers.forget_if_gone("/killed")
    assert "/killed" in (await node.snapshot()).nodes
    await close_servers([listener])
    await listener.wait_closed()
    assert await leftovers.forget_if_gone("/killed")
    snapshot = await node.snapshot()
    assert snapshot.nodes == ("/alive",)
    assert set(snapshot.services) == {"/switch"}
    await killed.close()
    await node.close()
    await master.close()
