"""The graphs for the tests of web clients: in memory, with ROS 1, and with only ROS 2."""

from __future__ import annotations

import functools
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass

from contract.zenoh_graphs import open_session
from interop.ros1_peers import free_port
from rostether.errors import MasterUnreachableError
from rostether.gateways.rosbridge.form_source import Style
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import JoinGraph
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node import join_ros1
from rostether.ros1.node.service_probe import probe_type
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeClasses, NativeTypes
from rostether.serde.store import TypeStore


@dataclass(frozen=True, slots=True)
class WebGraph:
    """An empty graph, and the function with which a gateway joins it."""

    join: JoinGraph
    store: TypeStore
    style: Style = Style.ROS1
    ask_type: Callable[[str], Awaitable[str]] | None = None


@asynccontextmanager
async def _memory() -> AsyncIterator[WebGraph]:
    yield WebGraph(MemoryNetwork().join, TypeStore(Registry()))


@asynccontextmanager
async def _ros1() -> AsyncIterator[WebGraph]:
    master = await MasterServer.start(port=0)
    client = MasterClient(master.uri, "/asking")
    yield WebGraph(
        functools.partial(join_ros1, environment=RosEnvironment.read({}).with_master(master.uri)),
        TypeStore(Registry()),
        ask_type=functools.partial(probe_type, client),
    )
    await client.close()
    await master.close()


@asynccontextmanager
async def _zenoh() -> AsyncIterator[WebGraph]:
    registry = NativeRegistry.from_environment(environ={})
    types = NativeTypes(registry)
    for attempt in range(5):
        try:
            session = await open_session(free_port(), is_router=True, types=types)
            break
        except MasterUnreachableError:
            # Another program's connection has just used the port.
            if attempt == 4:
                raise
    yield WebGraph(session.join, TypeStore(registry, NativeClasses(registry)), Style.ROS2)
    await session.close()


GRAPHS: dict[str, Callable[[], AbstractAsyncContextManager[WebGraph]]] = {
    "memory": _memory,
    "ros1": _ros1,
    "zenoh": _zenoh,
}
