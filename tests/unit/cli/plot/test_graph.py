from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from unit.cli.command_shell import STORE, LiveGraph, Shell

SVG = "{http://www.w3.org/2000/svg}"


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
@pytest.mark.parametrize(
    "name", ["graph.svg", pytest.param("graph.png", marks=pytest.mark.font), "graph.dot", "graph.txt"]
)
def test_files_by_their_names(shell: Shell, tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    assert shell.output("graph", "-o", str(file)) == f"{file}: 2 nodes, 1 topic\n"
    content = file.read_bytes()
    if name.endswith("svg"):
        texts = {each.text for each in ET.fromstring(content).iter(f"{SVG}text")}
        assert texts == {"/talker", "/listener", "/chatter"}
    elif name.endswith("png"):
        assert content.startswith(b"\x89PNG\r\n\x1a\n")
    else:
        assert b"/talker" in content


@pytest.mark.usefixtures("busy")
def test_mistakes_are_reported(shell: Shell, tmp_path: Path) -> None:
    assert "its name must end with .svg" in shell.failure(
        "graph", "--save", str(tmp_path / "graph.gif"), code=2
    )
    assert "give one of" in shell.failure("graph", "--json", "--format", "dot", code=2)
    assert "no node, topic or namespace /ghost" in shell.failure("graph", "ghost")
    missing = tmp_path / "missing" / "graph.svg"
    assert "cannot write" in shell.failure("graph", "--save", str(missing))


@pytest.mark.font
def test_an_empty_graph(shell: Shell, graph: LiveGraph, tmp_path: Path) -> None:
    assert shell.output("graph") == "no nodes\n"
    for name in ("graph.svg", "graph.png"):
        shell.output("graph", "--save", str(tmp_path / name))
