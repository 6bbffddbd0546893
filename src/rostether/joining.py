"""Joining a ROS graph from a program: `async with rostether.join("/talker") as graph: ...`."""

from __future__ import annotations

import os
import random
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path

from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore


@asynccontextmanager
async def join(
    node_name: str | None = None,
    *,
    master: str | None = None,
    namespace: str | None = None,
    remappings: Mapping[str, str] | None = None,
    msg_paths: Iterable[Path | str] = (),
    environ: Mapping[str, str] | None = None,
    allow: Iterable[str] = (),
) -> AsyncIterator[TypedGraph]:
    """Be a node of a ROS graph as long as the block lasts.

    Without a name the node gets one that nobody else has. `master` and `namespace` win over ROS_MASTER_URI
    and ROS_NAMESPACE; `msg_paths` are folders with message definitions of your own. With `allow` only
    machines in these networks (`192.168.1.0/24`) may connect to the node, and this one.
    Raises MasterUnreachableError, InvalidNameError, ConfigError.
    """
    environment = RosEnvironment.read(environ).allowing(allow)
    if master is not None:
        environment = environment.with_master(master)
    store = TypeStore(Registry.from_environment(msg_paths, environ))
    graph = await join_ros1(
        node_name if node_name is not None else anonymous_name("rostether"),
        environment=environment,
        namespace=environment.namespace if namespace is None else namespace,
        remappings=remappings,
    )
    try:
        yield TypedGraph(graph, store)
    finally:
        await graph.close()


def anonymous_name(base_name: str) -> str:
    """Return a node name that no other process and no earlier one of ours has."""
    return f"{base_name}_{os.getpid()}_{random.getrandbits(32):08x}"
