from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from rostether.cli.plot.graph_shown import as_digraph, as_text, choose
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from unit.cli.command_shell import STORE, LiveGraph, Shell

SVG = "{http://www.w3.org/2000/svg}"
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
def test_names_choose_what_is_connected(name: str, nodes: list[str], topics: list[str]) -> None:
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


@pytest.fixture
def busy(graph: LiveGraph) -> LiveGraph:
    text = STORE.registry.message_type("std_msgs/String")
    graph.do(graph.node("/talker").advertise("/chatter", text))
    graph.do(graph.node("/listener").subscribe("/chatter", text, lambda _payloads: None))
    return graph


@pytest.mark.usefixtures("busy")
def test_text_of_a_live_graph(shell: Shell) -> None:
    assert shell.output("graph").splitlines() == [
        "/listener",
        "  <- /chatter [std_msgs/String] from /talker",
        "/talker",
        "  -> /chatter [std_msgs/String] to /listener",
    ]


@pytest.mark.usefixtures("busy")
def test_json_has_nodes_and_topics(shell: Shell) -> None:
    records = shell("graph", "--json").records
    assert {"node": "/talker", "publishes": ["/chatter"], "subscribes": [], "services": []} in records
    assert {
        "topic": "/chatter",
        "type": "std_msgs/String",
        "publishers": ["/talker"],
        "subscribers": ["/listener"],
    } in records


@pytest.mark.usefixtures("busy")
def test_dot_is_graphvizs(shell: Shell) -> None:
    text = shell.output("graph", "--format", "dot")
    assert '"node /talker" [label="/talker", shape=ellipse];' in text
    assert '"topic /chatter" [label="/chatter", shape=box];' in text
    assert '"node /talker" -> "topic /chatter";' in text


@pytest.mark.usefixtures("busy")
@pytest.mark.parametrize("name", ["graph.svg", "graph.png", "graph.dot", "graph.txt"])
def test_files_by_their_names(shell: Shell, tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    assert shell.output("graph", "-o", str(file)) == f"{file}: 2 nodes, 1 topics\n"
    content = file.read_bytes()
    if name.endswith("svg"):
        texts = {each.text for each in ET.fromstring(content).iter(f"{SVG}text")}
        assert texts == {"/talker", "/listener", "/chatter"}
    elif name.endswith("png"):
        assert content.startswith(b"\x89PNG\r\n\x1a\n")
    else:
        assert b"/talker" in content


@pytest.mark.usefixtures("busy")
def test_what_cannot_be_done_is_reported(shell: Shell, tmp_path: Path) -> None:
    assert "its name must end with .svg" in shell.failure(
        "graph", "--save", str(tmp_path / "graph.gif"), code=2
    )
    assert "give one of" in shell.failure("graph", "--json", "--format", "dot", code=2)
    assert "no node, topic or namespace /ghost" in shell.failure("graph", "ghost")
    missing = tmp_path / "missing" / "graph.svg"
    assert "cannot write" in shell.failure("graph", "--save", str(missing))


def test_an_empty_graph(shell: Shell, graph: LiveGraph, tmp_path: Path) -> None:
    assert shell.output("graph") == "no nodes\n"
    for name in ("graph.svg", "graph.png"):
        shell.output("graph", "--save", str(tmp_path / name))
