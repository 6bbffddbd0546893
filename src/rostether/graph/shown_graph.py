"""The part of a graph that `rostether graph` shows: as text, as records, as vertices and edges."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.errors import UnknownNameError
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.mechanisms.text import escape_line
from rostether.msgdef.interface import ANY_TYPE
from rostether.names.graph_name import NODE_SERVICES, is_hidden, is_in_namespace

if TYPE_CHECKING:
    from rostether.pictures.digraph import Digraph

# Almost every node is connected to these, so they hide the other connections.
_HIDDEN_TOPICS = frozenset({"/rosout", "/rosout_agg", "/statistics", "/parameter_events"})
_HIDDEN_NODES = frozenset({"/rosout"})


class ShownGraph(Struct, frozen=True):
    """The chosen part of a graph, sorted by name."""

    nodes: Sequence[str]
    topics: Sequence[TopicEntry]
    services: Sequence[ServiceEntry]


def choose(snapshot: Snapshot, names: Iterable[str] = (), *, with_hidden: bool = False) -> ShownGraph:
    """Select the nodes and topics with one of `names`, or in a namespace of that name, and their neighbors.

    Raises UnknownNameError for a name that is not in the graph.
    """
    nodes, topics = list(snapshot.nodes), list(snapshot.topics.values())
    services = list(snapshot.services.values())
    if not with_hidden:
        nodes = [each for each in nodes if each not in _HIDDEN_NODES and not is_hidden(each)]
        topics = [each for each in topics if each.name not in _HIDDEN_TOPICS and not is_hidden(each.name)]
        services = [
            each
            for each in services
            if each.name.rpartition("/")[2] not in NODE_SERVICES and not is_hidden(each.name)
        ]
    wanted = ["/" + name.strip("/") for name in names]
    known = [*nodes, *(topic.name for topic in topics)]
    for name in wanted:
        if not any(is_in_namespace(each, name) for each in known):
            raise UnknownNameError(
                f"there is no node, topic or namespace {name}; `rostether graph` shows all"
            )
    if wanted:
        chosen = {each for each in nodes if _is_in(each, wanted)}
        topics = [each for each in topics if _is_in(each.name, wanted) or chosen & _ends(each)]
        near = chosen.union(*map(_ends, topics))
        nodes = [each for each in nodes if each in near]
    left = set(nodes)
    return ShownGraph(nodes, [_without(each, left) for each in topics], services)


def as_text(shown: ShownGraph) -> Iterator[str]:
    """Yield lines: each node with its publications, subscriptions and services, and the other ends."""
    for node in shown.nodes:
        yield escape_line(node)
        for topic in shown.topics:
            if node in topic.publishers:
                yield f"  -> {_topic(topic)}{_others(' to', topic.subscribers)}"
        for topic in shown.topics:
            if node in topic.subscribers:
                yield f"  <- {_topic(topic)}{_others(' from', topic.publishers)}"
        for service in shown.services:
            if node in service.providers:
                kind = "" if service.type == ANY_TYPE else f" [{escape_line(service.type)}]"
                yield f"  => {escape_line(service.name)}{kind}"
    if not shown.nodes:
        yield "no nodes"


def as_records(shown: ShownGraph) -> Iterator[Mapping[str, object]]:
    """Yield an object for each node, then one for each topic."""
    for node in shown.nodes:
        yield {
            "node": node,
            "publishes": [each.name for each in shown.topics if node in each.publishers],
            "subscribes": [each.name for each in shown.topics if node in each.subscribers],
            "services": [each.name for each in shown.services if node in each.providers],
        }
    for topic in shown.topics:
        yield {
            "topic": topic.name,
            "type": None if topic.type == ANY_TYPE else topic.type,
            "publishers": list(topic.publishers),
            "subscribers": list(topic.subscribers),
        }


def as_digraph(shown: ShownGraph, *, nodes_only: bool = False) -> Digraph:
    """Return the vertices and edges of a picture; topics are vertices too, unless `nodes_only`."""
    from rostether.pictures.digraph import Digraph, Edge, Shape, Vertex

    vertices = [Vertex(f"node {each}", escape_line(each), Shape.ELLIPSE) for each in shown.nodes]
    edges = []
    for topic in shown.topics:
        name = escape_line(topic.name)
        if nodes_only:
            edges += [
                Edge(f"node {source}", f"node {target}", name)
                for source in topic.publishers
                for target in topic.subscribers
            ]
            continue
        key = f"topic {topic.name}"
        vertices.append(Vertex(key, name, Shape.BOX))
        edges += [Edge(f"node {each}", key) for each in topic.publishers]
        edges += [Edge(key, f"node {each}") for each in topic.subscribers]
    return Digraph(vertices, edges)


def _is_in(name: str, namespaces: Iterable[str]) -> bool:
    return any(is_in_namespace(name, each) for each in namespaces)


def _ends(topic: TopicEntry) -> set[str]:
    return {*topic.publishers, *topic.subscribers}


def _without(topic: TopicEntry, nodes: set[str]) -> TopicEntry:
    publishers = tuple(each for each in dict.fromkeys(topic.publishers) if each in nodes)
    subscribers = tuple(each for each in dict.fromkeys(topic.subscribers) if each in nodes)
    return TopicEntry(topic.name, topic.type, publishers, subscribers)


def _topic(topic: TopicEntry) -> str:
    kind = "unknown type" if topic.type == ANY_TYPE else topic.type
    return f"{escape_line(topic.name)} [{escape_line(kind)}]"


def _others(word: str, nodes: Sequence[str]) -> str:
    return f"{word} {', '.join(map(escape_line, nodes))}" if nodes else f"{word} no node"
