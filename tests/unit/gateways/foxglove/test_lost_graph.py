"""A gateway whose ROS 1 master ends and comes back."""

from __future__ import annotations

from rostether.gateways.foxglove.gateway import FoxgloveGateway
from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.graph.memory_network import MemoryNetwork
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from unit.gateways.foxglove.protocol_client import Stage


async def test_clients_get_a_report_while_the_master_is_away() -> None:
    master = await MasterServer.start(port=0)
    graph = await join_ros1("/foxglove", environment=RosEnvironment.read().with_master(master.uri))
    store, network = TypeStore(Registry()), MemoryNetwork()
    async with FoxgloveGateway(graph, store, FoxgloveSettings(port=0)) as gateway:
        there = Stage(gateway, store, network, await network.join("/robot"), [])
        async with there.client() as client:
            await client.wait("advertise")
            await master.close()
            status = await client.wait("status")
            assert status["id"] == "graph"
            assert "cannot be reached" in status["message"]
            async with there.client() as later:
                assert (await later.wait("status"))["message"] == status["message"]
            master = await MasterServer.start(port=int(master.uri.rstrip("/").rpartition(":")[2]))
            assert (await client.wait("removeStatus"))["statusIds"] == ["graph"]
    await graph.close()
    await master.close()
