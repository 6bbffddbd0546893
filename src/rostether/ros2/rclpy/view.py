"""The middleware's view of the whole graph, now and at each change.

rclpy does not report changes of the graph, so it is polled; each poll costs about 0.05 ms per node.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rostether.graph.ports import Snapshot
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind
from rostether.ros2.graph_view import GraphView, as_snapshot

# Users do not notice this delay, and a hundred nodes need 1 % of a CPU.
POLL_INTERVAL_S = 0.5

# The name of a node in rmw while only its endpoints are discovered.
UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"


def full_name(name: str, namespace: str) -> str:
    """Return the full name of a node."""
    return f"{namespace.rstrip('/')}/{name}"


def node_name_of(endpoint: Any) -> str:
    """Return the full name of an endpoint's node; empty if only the endpoint has been discovered."""
    return (
        "" if endpoint.node_name == UNKNOWN_NODE else full_name(endpoint.node_name, endpoint.node_namespace)
    )


def take_snapshot(node: Any) -> Snapshot:
    """Return all nodes, topics and services; call it in the executor's thread."""
    names = [full_name(name, namespace) for name, namespace in _nodes(node)]
    queries = (
        (EndpointKind.PUBLISHER, node.get_publisher_names_and_types_by_node),
        (EndpointKind.SUBSCRIPTION, node.get_subscriber_names_and_types_by_node),
        (EndpointKind.SERVER, node.get_service_names_and_types_by_node),
    )
    return as_snapshot(GraphView(names, list(ask_nodes(node, queries))))


def offered_types(node: Any, service: str) -> list[str]:
    """Return the types of a service's servers; call it in the executor's thread.

    rclpy's list of all services also contains clients, so each node is asked.
    """
    servers = ask_nodes(node, [(EndpointKind.SERVER, node.get_service_names_and_types_by_node)])
    return sorted({each.type for each in servers if each.name == service})


def ask_nodes(
    node: Any, queries: Sequence[tuple[EndpointKind, Callable[[str, str], Any]]]
) -> Iterator[EndpointInfo]:
    """Yield the endpoints that all nodes have, with rclpy's query for each kind, but without details."""
    for name, namespace in _nodes(node):
        node_name = full_name(name, namespace)
        for kind, query in queries:
            try:
                found = query(name, namespace)
            except Exception:  # noqa: BLE001, S112 - rclpy's error has several names
                # The node has disappeared since it was listed.
                continue
            for endpoint, types in found:
                for type_name in types:
                    yield EndpointInfo(node_name, kind, endpoint, type_name)


def _nodes(node: Any) -> list[tuple[str, str]]:
    return [each for each in node.get_node_names_and_namespaces() if each[0] != UNKNOWN_NODE]
