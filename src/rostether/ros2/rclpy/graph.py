"""The graph port over rclpy: one context for all nodes of a process, and a thread for each node.

The context is one participant on the network. After each event, rclpy checks everything that a thread waits
for. With one thread per node, a board's latency does not grow with the number of boards.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from typing import Any

from rostether.errors import GraphError
from rostether.graph.ports import Level, Snapshot
from rostether.graph.snapshots import poll_snapshots
from rostether.names.graph_name import join, validate_name
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.rclpy.endpoint_handles import RclpyEndpoints
from rostether.ros2.rclpy.executor_thread import ExecutorThread
from rostether.ros2.rclpy.failures import attempt
from rostether.ros2.rclpy.installation import load_rclpy, rclpy_distribution
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.own_parameters import RclpyParameters
from rostether.ros2.rclpy.view import POLL_INTERVAL_S, ask_nodes, node_name_of, take_snapshot
from rostether.ros2.types.type_support import Ros2Types
from rostether.rostime import Time


class RclpyContext:
    """Opens nodes on a ROS 2 graph through rclpy and its installed middleware.

    rclpy and the middleware read other settings from the environment of the process: RMW_IMPLEMENTATION,
    ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS, and the middleware's own variables.
    """

    def __init__(self, context: Any, types: Ros2Types, arguments: Sequence[str]) -> None:
        self._context = context
        self.types = types
        self._arguments = arguments
        self._graphs: set[RclpyGraph] = set()
        # Nodes are created one after the other: rcl's context is not thread-safe.
        self._lock = asyncio.Lock()
        self._is_closed = False

    @classmethod
    async def open(cls, types: Ros2Types, *, domain_id: int, arguments: Sequence[str] = ()) -> RclpyContext:
        """Start rclpy in a domain.

        `arguments` are passed to every node, such as `["--ros-args", "--params-file", "a.yaml"]`.
        Raises ConfigError if rclpy is not installed, GraphError if it does not start.
        """
        rclpy = await asyncio.to_thread(load_rclpy)
        context = rclpy.context.Context()
        attempt("start rclpy", lambda: context.init(args=[], domain_id=domain_id))
        return cls(context, types, list(arguments))

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> RclpyGraph:
        """Join as `node_name`; another node with this name may exist. Raises InvalidNameError, GraphError."""
        full_name = join(namespace, validate_name(node_name))
        if self._is_closed:
            raise GraphError("rclpy has been shut down; open it again")
        thread = ExecutorThread(self._context)
        try:
            async with self._lock:
                own = await thread.run(
                    lambda: OwnNode(
                        full_name,
                        context=self._context,
                        thread=thread,
                        types=self.types,
                        arguments=self._arguments,
                    )
                )
        except BaseException:
            await thread.stop()
            raise
        graph = RclpyGraph(own, namespace, remappings or {}, on_close=self._graphs.discard)
        self._graphs.add(graph)
        return graph

    async def close(self) -> None:
        """Leave with all nodes, and end rclpy. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        await asyncio.gather(*(graph.close() for graph in list(self._graphs)))
        await asyncio.to_thread(self._end)

    def _end(self) -> None:
        attempt("end rclpy", self._context.try_shutdown)
        attempt("end rclpy", self._context.destroy)


class RclpyGraph(RclpyEndpoints):
    """Implements `graph.ports.Graph`; made by `RclpyContext.join`."""

    def __init__(
        self,
        own: OwnNode,
        namespace: str,
        remappings: Mapping[str, str],
        *,
        on_close: Callable[[RclpyGraph], object],
    ) -> None:
        super().__init__(own, namespace, remappings)
        self._on_close = on_close
        self._parameters = GraphParameters(RclpyParameters(own), self)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self._own.log(level, text)

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return Time.from_ns(self._own.now_ns())

    async def snapshot(self) -> Snapshot:
        """Return this node's view of the whole graph."""
        return await self._own.thread.run(lambda: take_snapshot(self._own.node))

    async def endpoints(self) -> list[EndpointInfo]:
        """Return all known endpoints of topics and services."""
        return await self._own.thread.run(lambda: list_endpoints(self._own.node))

    async def distribution(self) -> str:
        """Return the distribution of the installed rclpy; empty if its version is unknown."""
        return rclpy_distribution()

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change, within about half a second of it."""
        return poll_snapshots(self.snapshot, self._closed, POLL_INTERVAL_S)

    async def _end(self) -> None:
        try:
            await self._parameters.close()
            await self._close_endpoints()
            await self._own.thread.run(self._own.destroy)
        finally:
            await self._own.thread.stop()
            self._on_close(self)


def list_endpoints(node: Any) -> list[EndpointInfo]:
    """Return all endpoints of topics and services; call it in the executor's thread."""
    queries = (
        (EndpointKind.SERVER, node.get_service_names_and_types_by_node),
        (EndpointKind.CLIENT, node.get_client_names_and_types_by_node),
    )
    return [*_topic_ends(node), *ask_nodes(node, queries)]


def _topic_ends(node: Any) -> Iterator[EndpointInfo]:
    for topic, _ in node.get_topic_names_and_types():
        for kind, ask in (
            (EndpointKind.PUBLISHER, node.get_publishers_info_by_topic),
            (EndpointKind.SUBSCRIPTION, node.get_subscriptions_info_by_topic),
        ):
            for info in ask(topic):
                if node_name := node_name_of(info):
                    yield EndpointInfo(
                        node_name,
                        kind,
                        topic,
                        info.topic_type,
                        str(getattr(info, "topic_type_hash", "")),
                        bytes(info.endpoint_gid),
                        _report(info.qos_profile),
                    )


def _report(profile: Any) -> QosReport:
    return QosReport(
        profile.reliability.name,
        profile.durability.name,
        profile.history.name,
        profile.depth,
        str(profile.lifespan),
        str(profile.deadline),
        profile.liveliness.name,
        str(profile.liveliness_lease_duration),
    )
