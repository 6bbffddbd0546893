"""Makes a snapshot of a ROS 2 graph for pictures, with ROS 2 type names."""

from __future__ import annotations

from rostether.cli.access.ros2_view import SERVICE_KINDS, TOPIC_KINDS, GraphView
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.ros2.endpoint_info import EndpointKind


def as_snapshot(view: GraphView) -> Snapshot:
    """Return all nodes, topics and services of a view, including hidden ones."""
    return Snapshot(
        tuple(sorted(set(view.nodes))),
        {
            name: TopicEntry(
                name,
                ", ".join(view.types(TOPIC_KINDS, name)),
                _nodes(view, EndpointKind.PUBLISHER, name),
                _nodes(view, EndpointKind.SUBSCRIPTION, name),
            )
            for name in view.names(TOPIC_KINDS, with_hidden=True)
        },
        {
            name: ServiceEntry(
                name,
                _nodes(view, EndpointKind.SERVER, name),
                ", ".join(view.types(SERVICE_KINDS, name)),
            )
            for name in view.names([EndpointKind.SERVER], with_hidden=True)
        },
    )


def _nodes(view: GraphView, kind: EndpointKind, name: str) -> tuple[str, ...]:
    return tuple(sorted({end.node_name for end in view.of(kind, name)}))
