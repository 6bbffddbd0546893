"""Serving boards on a ROS 1 graph: what `serve`, `serial-node` and `demo` have in common."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rostether.ros1.environment import RosEnvironment

if TYPE_CHECKING:
    from pathlib import Path

    from rostether.bridge.reporter import Reporter
    from rostether.bridge.supervisor import Supervisor
    from rostether.ros1.node.node import Ros1Graph
    from rostether.transports.address import Address


@asynccontextmanager
async def bridge(
    environment: RosEnvironment,
    addresses: Sequence[Address],
    reporter: Reporter,
    *,
    msg_paths: Sequence[Path] = (),
    ns_per_board: bool = False,
    remappings: Mapping[str, str] | None = None,
) -> AsyncIterator[Supervisor]:
    """Serve boards as long as the block lasts; its end tells them to stop and leaves the graph.

    Raises TransportOpenError for an address that cannot be listened on, InvalidNameError.
    """
    from rostether.bridge.supervisor import Supervisor
    from rostether.msgdef.registry import Registry
    from rostether.ros1.node.node import join_ros1
    from rostether.serde.store import TypeStore

    async def join(
        node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Ros1Graph:
        return await join_ros1(node_name, environment=environment, namespace=namespace, remappings=remappings)

    supervisor = Supervisor(
        join,
        TypeStore(Registry.from_environment(msg_paths)),
        reporter=reporter,
        ns_per_board=ns_per_board,
        remappings=remappings,
    )
    try:
        await supervisor.start(addresses)
        yield supervisor
    finally:
        await supervisor.close()
