"""A node of a ROS 2 graph: the graph port over rclpy."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from typing import Any

from rostether.graph.ports import Level, Snapshot
from rostether.graph.snapshots import poll_snapshots
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.rclpy.endpoint_handles import RclpyEndpoints
from rostether.ros2.rclpy.installation import rclpy_distribution
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.own_parameters import RclpyParameters
from rostether.ros2.rclpy.view import POLL_INTERVAL_S, ask_nodes, node_name_of, take_snapshot
from rostether.rostime import Time


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
