"""Joining a ROS graph from a program: `async with rostether.join("/talker") as graph: ...`."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Literal, TypeAlias

from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.anonymous import anonymous_name
from rostether.mechanisms.block_end import closed_at_end
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from rostether.serde.values import MessageClasses

Ros2Middleware: TypeAlias = Literal["zenoh", "rclpy"]


@asynccontextmanager
async def join(  # noqa: PLR0913 - each is an independent setting
    node_name: str | None = None,
    *,
    master: str | None = None,
    namespace: str | None = None,
    remappings: Mapping[str, str] | None = None,
    msg_paths: Iterable[Path | str] = (),
    environ: Mapping[str, str] | None = None,
    allow: Iterable[str] = (),
    ros2: Ros2Middleware | None = None,
    numpy: bool = False,
) -> AsyncIterator[TypedGraph]:
    """Join a ROS graph as a node until the end of the block.

    Without a name the node gets a unique one. `master` and `namespace` override ROS_MASTER_URI
    and ROS_NAMESPACE; `msg_paths` are folders with your own message definitions. With `allow`, only this
    machine and machines in these networks (`192.168.1.0/24`) may connect to the node.

    With `ros2`, it is a node of a ROS 2 graph, over zenoh or an installed rclpy: ROS_DOMAIN_ID and the
    variables of that middleware select the graph. Messages then have the fields of ROS 2 (a stamp has `sec`
    and `nanosec`, and there is no `seq`), types may be spelled `std_msgs/msg/String`, and parameters belong
    to nodes.

    With `numpy`, arrays of numbers in received messages are numpy arrays: read-only views without a copy.
    Raises MasterUnreachableError, GraphError, InvalidNameError, ConfigError.
    """
    if ros2 is not None:
        if master is not None or allow:
            raise ConfigError("master= and allow= work only with ROS 1; omit them with ros2=")
        async with _joined_ros2(ros2, node_name, namespace, remappings, msg_paths, environ, numpy) as typed:
            yield typed
        return
    environment = RosEnvironment.read(environ).allowing(allow)
    if master is not None:
        environment = environment.with_master(master)
    store = TypeStore(Registry.from_environment(msg_paths, environ), _classes(numpy))
    graph = await join_ros1(
        node_name if node_name is not None else anonymous_name("rostether"),
        environment=environment,
        namespace=environment.namespace if namespace is None else namespace,
        remappings=remappings,
    )
    async with closed_at_end(graph):
        yield TypedGraph(graph, store, reports_silence=True)


@asynccontextmanager
async def _joined_ros2(
    middleware: Ros2Middleware,
    node_name: str | None,
    namespace: str | None,
    remappings: Mapping[str, str] | None,
    msg_paths: Iterable[Path | str],
    environ: Mapping[str, str] | None,
    numpy: bool,
) -> AsyncIterator[TypedGraph]:
    # Imported here, because programs on ROS 1 alone need none of these modules.
    from rostether.ros2.session import open_ros2
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.ros2.types.native_types import NativeTypes

    registry = NativeRegistry.from_environment(msg_paths, environ)
    store = TypeStore(registry, _classes(numpy))
    async with open_ros2(middleware, NativeTypes(registry), environ) as access:
        graph = await access.join(
            node_name if node_name is not None else anonymous_name("rostether"),
            namespace=namespace or "/",
            remappings=remappings,
        )
        async with closed_at_end(graph):
            yield TypedGraph(graph, store, reports_silence=True)


def _classes(numpy: bool) -> MessageClasses:
    if not numpy:
        return MessageClasses()
    from rostether.serde.numpy_classes import NumpyClasses

    return NumpyClasses()
