"""Graphs over zenoh on a separate port: nodes that share a session, and nodes with one session each."""

from __future__ import annotations

import functools
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager

from interop.ros1_peers import free_port
from rostether.errors import MasterUnreachableError
from rostether.graph.ports import Graph, JoinGraph
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.types.type_support import Ros2Types
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach


@functools.cache
def ros2_types() -> Ros2Types:
    """Return the bundled types, compiled once for all tests."""
    return Ros2Types(Registry(), Ros2Definitions())


async def open_session(
    port: int, *, is_router: bool, domain_id: int = 0, types: Ros2Types | None = None
) -> ZenohSession:
    """Open a session that connects to others only at a port on loopback."""
    endpoint = f'["tcp/127.0.0.1:{port}"]'
    if is_router:
        overrides: tuple[tuple[str, str], ...] = (("listen/endpoints", endpoint),)
    else:
        overrides = (("listen/endpoints", '["tcp/127.0.0.1:0"]'), ("connect/endpoints", endpoint))
    choice = RouterChoice.ALWAYS if is_router else RouterChoice.NEVER
    environment = Ros2Environment(domain_id=domain_id, zenoh_overrides=overrides)
    return await ZenohSession.open(environment, types or ros2_types(), reach=ZenohReach(choice))


async def open_router(domain_id: int = 0) -> tuple[ZenohSession, int]:
    """Open a session that is the router of a free port; return it with the port."""
    for _ in range(5):
        port = free_port()
        try:
            return await open_session(port, is_router=True, domain_id=domain_id), port
        except MasterUnreachableError:
            continue  # Another program's connection has just used the port.
    raise AssertionError("no port stays free")


@asynccontextmanager
async def open_one_session() -> AsyncIterator[JoinGraph]:
    """Join nodes of one session, as a bridge does."""
    session, _ = await open_router()
    try:
        yield session.join
    finally:
        await session.close()


@asynccontextmanager
async def open_sessions() -> AsyncIterator[JoinGraph]:
    """Join nodes with one session each; the first one is the router of the others."""
    port: int | None = None
    async with AsyncExitStack() as stack:

        async def join(
            node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
        ) -> Graph:
            nonlocal port
            if port is None:
                session, port = await open_router()
            else:
                session = await open_session(port, is_router=False)
            stack.push_async_callback(session.close)
            return await session.join(node_name, namespace=namespace, remappings=remappings)

        yield join
