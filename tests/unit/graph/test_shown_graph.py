from __future__ import annotations

import pytest

from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.graph.shown_graph import as_digraph, as_text, choose

SNAPSHOT = Snapshot(
    ("/arm/controller", "/board", "/rosout", "/viewer"),
    {
        each.name: each
        for each in (
            TopicEntry("/arm/goal", "*", (), ("/arm/controller",)),
            TopicEntry("/rosout", "rosgraph_msgs/Log", ("/arm/controller", "/board"), ("/rosout",)),
            TopicEntry("/scan", "sensor_msgs/Range", ("/board",), ("/arm/controller", "/viewer")),
            TopicEntry("/servo", "std_msgs/Int16", ("/arm/controller",), ("/board",)),
        )
    },
    {
        "/arm/controller/get_loggers": ServiceEntry("/arm/controller/get_loggers", ("/arm/controller",)),
        "/move": ServiceEntry("/move", ("/arm/controller",)),
    },
)


def test_text_shows_both_ends_of_each_topic() -> None:
    assert list(as_text(choose(SNAPSHOT))) == [
        "/arm/controller",
        "  -> /servo [std_msgs/Int16] to /board",
        "  <- /arm/goal [unknown type] from no node",
        "  <- /scan [sensor_msgs/Range] from /board",
        "  => /move",
        "/board",
        "  -> /scan [sensor_msgs/Range] to /arm/controller, /viewer",
        "  <- /servo [std_msgs/Int16] from /arm/controller",
        "/viewer",
        "  <- /scan [sensor_msgs/Range] from /board",
    ]


def test_logging_is_shown_on_request() -> None:
    shown = choose(SNAPSHOT, with_hidden=True)
    assert "/rosout" in shown.nodes
    assert "/rosout" in [topic.name for topic in shown.topics]
    assert "/arm/controller/get_loggers" in [service.name for service in shown.services]


@pytest.mark.parametrize(
    ("name", "nodes", "topics"),
    [
        ("/viewer", ["/arm/controller", "/board", "/viewer"], ["/scan"]),
        ("servo", ["/arm/controller", "/board"], ["/servo"]),
        ("/arm", ["/arm/controller", "/board", "/viewer"], ["/arm/goal", "/scan", "/servo"]),
    ],
)
def test_names_choose_connected_nodes_and_topics(name: str, nodes: list[str], topics: list[str]) -> None:
    shown = choose(SNAPSHOT, [name])
    assert (list(shown.nodes), [topic.name for topic in shown.topics]) == (nodes, topics)


def test_edges_follow_the_messages() -> None:
    edges = {(edge.source, edge.target) for edge in as_digraph(choose(SNAPSHOT)).edges}
    assert edges == {
        ("topic /arm/goal", "node /arm/controller"),
        ("node /board", "topic /scan"),
        ("topic /scan", "node /arm/controller"),
        ("topic /scan", "node /viewer"),
        ("node /arm/controller", "topic /servo"),
        ("topic /servo", "node /board"),
    }


def test_nodes_alone_are_connected_by_topics() -> None:
    digraph = as_digraph(choose(SNAPSHOT), nodes_only=True)
    assert {vertex.label for vertex in digraph.vertices} == {"/arm/controller", "/board", "/viewer"}
    assert {(edge.source, edge.target, edge.label) for edge in digraph.edges} == {
        ("node /board", "node /arm/controller", "/scan"),
        ("node /board", "node /viewer", "/scan"),
        ("node /arm/controller", "node /board", "/servo"),
    }
