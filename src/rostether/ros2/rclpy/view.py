"""The middleware's view of the whole graph, now and at each change.

rclpy does not report changes of the graph, so it is polled; each poll costs about 0.1 ms per node.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry

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
    names = sorted(
        (namespace, name) for name, namespace in node.get_node_names_and_namespaces() if name != UNKNOWN_NODE
    )
    types: dict[str, set[str]] = {}
    publishers: dict[str, set[str]] = {}
    subscribers: dict[str, set[str]] = {}
    providers: dict[str, set[str]] = {}
    service_types: dict[str, set[str]] = {}
    for namespace, name in names:
        node_name = full_name(name, namespace)
        for table, ask in (
            (publishers, node.get_publisher_names_and_types_by_node),
            (subscribers, node.get_subscriber_names_and_types_by_node),
        ):
            for topic, type_names in ask_node(ask, name, namespace):
                table.setdefault(topic, set()).add(node_name)
                types.setdefault(topic, set()).update(type_names)
        for service, type_names in ask_node(node.get_service_names_and_types_by_node, name, namespace):
            providers.setdefault(service, set()).add(node_name)
            service_types.setdefault(service, set()).update(type_names)
    return Snapshot(
        nodes=tuple(sorted({full_name(name, namespace) for namespace, name in names})),
        topics={
            topic: TopicEntry(
                topic,
                " ".join(sorted(types[topic])),
                tuple(sorted(publishers.get(topic, ()))),
                tuple(sorted(subscribers.get(topic, ()))),
            )
            for topic in sorted(types)
        },
        services={
            service: ServiceEntry(service, tuple(sorted(nodes)), " ".join(sorted(service_types[service])))
            for service, nodes in sorted(providers.items())
        },
    )


def offered_types(node: Any, service: str) -> list[str]:
    """Return the types of a service's servers; call it in the executor's thread.

    rclpy's list of all services also contains clients, so each node is asked.
    """
    types: set[str] = set()
    for name, namespace in node.get_node_names_and_namespaces():
        types.update(
            dict(ask_node(node.get_service_names_and_types_by_node, name, namespace)).get(service, ())
        )
    return sorted(types)


def ask_node(query: Callable[[str, str], Any], name: str, namespace: str) -> Any:
    """Return the result of a query about a node; empty if the node has disappeared since it was listed."""
    try:
        return query(name, namespace)
    except Exception:  # noqa: BLE001 - rclpy's error has several names
        return ()
