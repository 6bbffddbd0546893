"""The endpoints of a graph's topics and services in detail, as `ros2 topic info -v` shows them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Protocol, runtime_checkable

from msgspec import Struct

from rostether.graph.ports import Graph
from rostether.msgdef.interface import MessageType
from rostether.msgdef.ros2.definition_files import BUNDLED_DISTRO, named_distro

INFINITE = "Infinite"


class EndpointKind(Enum):
    """The kind of an endpoint; the names are those of rclpy."""

    PUBLISHER = "PUBLISHER"
    SUBSCRIPTION = "SUBSCRIPTION"
    SERVER = "SERVER"
    CLIENT = "CLIENT"


class QosReport(Struct, frozen=True):
    """Quality of service in rclpy's terms; a policy that the middleware does not report is UNKNOWN."""

    reliability: str
    durability: str
    history: str
    depth: int
    lifespan: str = INFINITE
    deadline: str = INFINITE
    liveliness: str = "AUTOMATIC"
    lease: str = INFINITE


class EndpointInfo(Struct, frozen=True):
    """One endpoint, with a type such as `std_msgs/msg/String`.

    Fields that the middleware does not report are empty or None.
    """

    node_name: str
    kind: EndpointKind
    name: str
    type: str
    type_hash: str = ""
    gid: bytes = b""
    qos: QosReport | None = None


@runtime_checkable
class Ros2Graph(Graph, Protocol):
    """A `graph.ports.Graph` of ROS 2."""

    async def endpoints(self) -> list[EndpointInfo]:
        """Return all known endpoints of topics and services."""

    async def distribution(self) -> str:
        """Return the name of the distribution that the graph shows; empty if it shows none."""


def connection_fields(
    topic: str, message_type: MessageType, node_name: str, *, is_latching: bool, reliability: str
) -> dict[str, str]:
    """Return the fields of ROS 1's connection header for a publisher, and its reliability in lower case."""
    return {
        "callerid": node_name,
        "topic": topic,
        "type": message_type.name,
        "md5sum": message_type.md5sum,
        "message_definition": message_type.definition,
        "latching": "1" if is_latching else "0",
        "reliability": reliability.lower(),
    }


def different_type_text(node_name: str, kind: EndpointKind, topic: str, other: str, own: str) -> str:
    """Return the report about a node whose publisher or subscription has another type than this node's."""
    verb = "publishes" if kind is EndpointKind.PUBLISHER else "subscribes to"
    return (
        f"{node_name:.200} {verb} {topic} as {other:.200}, but this node uses {own},"
        " so they do not connect; make both use the same type"
    )


async def find_distribution(graph: Graph, environ: Mapping[str, str]) -> str:
    """Return the distribution of a ROS 2 graph: ROS_DISTRO, else the graph's, else `BUNDLED_DISTRO`."""
    shown = await graph.distribution() if isinstance(graph, Ros2Graph) else ""
    return named_distro(environ) or shown or BUNDLED_DISTRO
