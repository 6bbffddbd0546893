"""The endpoints of a ROS 2 graph in detail, as `ros2 topic info -v` shows them, and views of whole graphs."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from typing import Protocol, runtime_checkable

from msgspec import Struct

from rostether.graph.ports import Graph, ServiceEntry, Snapshot, TopicEntry
from rostether.msgdef.interface import MessageType
from rostether.msgdef.ros2.definition_files import BUNDLED_DISTRO, named_distro
from rostether.names.graph_name import is_hidden

INFINITE = "Infinite"


class EndpointKind(Enum):
    """The kind of an endpoint; the names are those of rclpy."""

    PUBLISHER = "PUBLISHER"
    SUBSCRIPTION = "SUBSCRIPTION"
    SERVER = "SERVER"
    CLIENT = "CLIENT"


TOPIC_KINDS = (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION)
SERVICE_KINDS = (EndpointKind.SERVER, EndpointKind.CLIENT)


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


class ListedClient:
    """Implements `graph.ports.ServiceClient`; `close` calls `withdraw` once."""

    def __init__(self, withdraw: Callable[[], Awaitable[None]]) -> None:
        self._withdraw = withdraw
        self._is_closed = False

    async def close(self) -> None:
        """Remove the client from the graph. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            await self._withdraw()


class GraphView(Struct, frozen=True):
    """The names of nodes, repeated if several nodes share one, and the endpoints of topics and services."""

    nodes: Sequence[str]
    endpoints: Sequence[EndpointInfo]

    def names(self, kinds: Iterable[EndpointKind], *, with_hidden: bool = False) -> list[str]:
        """Return the names that have endpoints of these kinds, sorted."""
        wanted = set(kinds)
        found = {endpoint.name for endpoint in self.endpoints if endpoint.kind in wanted}
        return sorted(name for name in found if with_hidden or not is_hidden(name))

    def topics(self, *, with_hidden: bool = False) -> list[str]:
        """Return the names of all topics, sorted."""
        return self.names(TOPIC_KINDS, with_hidden=with_hidden)

    def services(self, *, with_hidden: bool = False) -> list[str]:
        """Return the names of all offered services, sorted."""
        return self.names([EndpointKind.SERVER], with_hidden=with_hidden)

    def of(self, kind: EndpointKind, name: str) -> list[EndpointInfo]:
        """Return the endpoints of a topic or service of one kind, in a stable order."""
        found = [endpoint for endpoint in self.endpoints if endpoint.kind is kind and endpoint.name == name]
        return sorted(found, key=lambda endpoint: (endpoint.node_name, endpoint.gid))

    def types(self, kinds: Iterable[EndpointKind], name: str) -> list[str]:
        """Return the types that a topic or service has, sorted."""
        return sorted({endpoint.type for kind in kinds for endpoint in self.of(kind, name)})

    def shown_type(self, kinds: Iterable[EndpointKind], name: str) -> str | list[str]:
        """Return the only type of a topic or service, or the list of its types."""
        return one_or_all(self.types(kinds, name))

    def of_node(self, kind: EndpointKind, node: str) -> Iterator[tuple[str, list[str]]]:
        """Yield the names and types of a node's endpoints of one kind, sorted."""
        types: dict[str, set[str]] = {}
        for endpoint in self.endpoints:
            if endpoint.kind is kind and endpoint.node_name == node:
                types.setdefault(endpoint.name, set()).add(endpoint.type)
        for name in sorted(types):
            yield name, sorted(types[name])


def one_or_all(types: list[str]) -> str | list[str]:
    """Return the only type, or the list if there is none or more than one."""
    return types[0] if len(types) == 1 else types


def as_snapshot(view: GraphView) -> Snapshot:
    """Return all nodes, topics and services of a view, including hidden ones."""
    nodes: dict[tuple[EndpointKind, str], set[str]] = {}
    topics: dict[str, set[str]] = {}
    services: dict[str, set[str]] = {}
    for each in view.endpoints:
        nodes.setdefault((each.kind, each.name), set()).add(each.node_name)
        types = topics if each.kind in TOPIC_KINDS else services
        types.setdefault(each.name, set()).add(each.type)

    def nodes_of(kind: EndpointKind, name: str) -> tuple[str, ...]:
        return tuple(sorted(nodes.get((kind, name), ())))

    return Snapshot(
        tuple(sorted(set(view.nodes))),
        {
            name: TopicEntry(
                name,
                " ".join(sorted(topics[name])),
                nodes_of(EndpointKind.PUBLISHER, name),
                nodes_of(EndpointKind.SUBSCRIPTION, name),
            )
            for name in sorted(topics)
        },
        {
            name: ServiceEntry(name, nodes_of(EndpointKind.SERVER, name), " ".join(sorted(services[name])))
            for name in sorted(services)
            if (EndpointKind.SERVER, name) in nodes
        },
    )
