"""A snapshot of a ROS 2 graph, with the queries that listings need."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from msgspec import Struct

from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.names.graph_name import is_hidden
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind

TOPIC_KINDS = (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION)

SERVICE_KINDS = (EndpointKind.SERVER, EndpointKind.CLIENT)


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
