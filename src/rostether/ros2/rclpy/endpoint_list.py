"""The endpoints of a graph in detail, as rclpy reports them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.rclpy.view import UNKNOWN_NODE


def list_endpoints(node: Any) -> list[EndpointInfo]:
    """Ask rclpy for everything, in the executor's thread."""
    return [*_topic_ends(node), *_service_ends(node)]


def _topic_ends(node: Any) -> Iterator[EndpointInfo]:
    for topic, _ in node.get_topic_names_and_types():
        for kind, ask in (
            (EndpointKind.PUBLISHER, node.get_publishers_info_by_topic),
            (EndpointKind.SUBSCRIPTION, node.get_subscriptions_info_by_topic),
        ):
            for info in ask(topic):
                if info.node_name != UNKNOWN_NODE:
                    yield EndpointInfo(
                        _full_name(info.node_name, info.node_namespace),
                        kind,
                        topic,
                        info.topic_type,
                        str(getattr(info, "topic_type_hash", "")),
                        bytes(info.endpoint_gid),
                        _report(info.qos_profile),
                    )


def _service_ends(node: Any) -> Iterator[EndpointInfo]:
    for name, namespace in node.get_node_names_and_namespaces():
        if name == UNKNOWN_NODE:
            continue
        for kind, ask in (
            (EndpointKind.SERVER, node.get_service_names_and_types_by_node),
            (EndpointKind.CLIENT, node.get_client_names_and_types_by_node),
        ):
            for service, types in _ask(ask, name, namespace):
                for type_name in types:
                    yield EndpointInfo(_full_name(name, namespace), kind, service, type_name)


def _ask(question: Callable[[str, str], Any], name: str, namespace: str) -> Any:
    try:
        return question(name, namespace)
    except Exception:  # noqa: BLE001 - the node has gone since it was named; rclpy's error has several names
        return ()


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


def _full_name(name: str, namespace: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"
