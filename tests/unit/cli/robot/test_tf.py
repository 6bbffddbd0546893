from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

from programs import running
from rostether.graph.typed_graph import TypedGraph
from rostether.robot.static_transforms import StaticTransform, publish_static_transform
from rostether.robot.transform import Transform, quaternion_from_rpy
from unit.cli.command_shell import STORE, LiveGraph, Shell


@pytest.fixture
def laser(graph: LiveGraph) -> None:
    """A node that publishes the pose of the laser on the base, and one that moves the base."""
    stands = StaticTransform("base", "laser", Transform((0.5, 0.0, 0.25), quaternion_from_rpy(0, 0, 1)))
    moves = StaticTransform("world", "base", Transform((1.0, 2.0, 0.0)), period_s=0.02)
    for name, static in (("stands", stands), ("moves", moves)):
        graph.begin(publish_static_transform(TypedGraph(graph.node(name), STORE), static))


def test_echo_prints_what_tf_echo_prints(laser: None, shell: Shell) -> None:
    lines = shell.output("tf", "echo", "-n", "1", "world", "/laser").splitlines()
    assert lines[0].startswith("At time ")
    assert lines[1:] == [
        "- Translation: [1.500, 2.000, 0.250]",
        "- Rotation: in Quaternion [0.000, 0.000, 0.479, 0.878]",
        "            in RPY (radian) [0.000, -0.000, 1.000]",
        "            in RPY (degree) [0.000, -0.000, 57.296]",
    ]


def test_echo_as_json(laser: None, shell: Shell) -> None:
    records = shell("tf", "echo", "--json", "-n", "2", "base", "laser", "50").records
    assert len(records) == 2
    assert records[0]["translation_m"] == [0.5, 0.0, 0.25]
    assert records[0]["rpy_rad"][2] == pytest.approx(1.0)
    assert (records[0]["parent"], records[0]["child"]) == ("base", "laser")


def test_echo_ends_after_its_time_limit(laser: None, shell: Shell) -> None:
    for limit_s in ("0.2", "5", "50"):
        result = shell("tf", "echo", "--timeout", limit_s, "world", "nowhere")
        assert result.code == 1
        # On a busy machine no transform may arrive in time.
        if "nowhere" in result.err:
            break
    assert '"nowhere" passed to lookupTransform argument source_frame does not exist.' in result.err


def test_tree(laser: None, shell: Shell) -> None:
    lines = shell.observed(r"Hz, /moves\).*laser", "tf", "tree").splitlines()
    assert lines[0] == "world"
    assert lines[1].startswith("└─ base  (")
    assert lines[1].endswith(" Hz, /moves)")
    assert lines[2] == "   └─ laser  (static, /stands)"


def test_tree_for_programs(laser: None, shell: Shell) -> None:
    pattern = r'(?=.*"laser").*"rate_hz": [1-9]'
    lines = shell.observed(pattern, "tf", "tree", "--json").splitlines()
    records = {each["frame"]: each for each in map(json.loads, lines)}
    assert records["laser"]["is_static"]
    assert records["laser"]["broadcaster"] == "/stands"
    assert records["base"]["rate_hz"] > 0
    dot = shell.observed('"base" -> "laser"', "tf", "tree", "--dot")
    assert dot.startswith("digraph G {")
    assert '"base" -> "laser"' in dot


def test_an_empty_tree_names_possible_publishers(graph: LiveGraph, shell: Shell) -> None:
    result = shell("tf", "tree", "--time", "0.1")
    assert result.code == 1
    assert "start robot_state_publisher or `rostether tf static`, which publish transforms" in result.err


def monitored(shell: Shell, pattern: str, *words: str) -> str:
    """Monitor until a pattern is printed: on a busy machine that may take more than one report."""
    for count in ("1", "10", "60"):
        text = shell.output("tf", "monitor", "-n", count, *words)
        if re.search(pattern, text, re.DOTALL):
            break
    return text


def test_monitor(laser: None, shell: Shell) -> None:
    text = monitored(shell, "laser published by /stands.*Node: /moves ")
    assert "RESULTS: for all Frames" in text
    assert "Frame: laser published by /stands Average Delay: 0 Max Delay: 0" in text
    assert "Node: /moves " in text


def test_monitor_a_chain(laser: None, shell: Shell) -> None:
    text = monitored(shell, "Chain is: ", "world", "laser")
    assert "Chain is: laser -> base -> world" in text
    records = monitored(shell, '"base".*"laser"', "--json").splitlines()
    assert {json.loads(each)["frame"] for each in records} == {"base", "laser"}
    assert "give PARENT and CHILD, or no frame" in shell.failure("tf", "monitor", "world", code=2)


@pytest.mark.parametrize("verb", [("tf", "static"), ("role", "static-transform-publisher")])
def test_static_publishes_until_interrupted(
    verb: tuple[str, str], graph: LiveGraph, shell: Shell, tmp_path: Path
) -> None:
    words = ["1", "-2", "-0.5", str(math.pi / 2), "0", "0", "world", "laser", "__name:=here"]
    with running(*verb, *words, ROS_MASTER_URI=graph.uri) as process:
        # If the process is slow to start, echo reports on stderr that it waits.
        result = shell("tf", "echo", "-n", "1", "world", "laser")
        assert result.code == 0
        assert "[1.000, -2.000, -0.500]" in result.out
        assert "/here" in shell.output("node", "list")
        process.terminate()
        assert process.wait(60) == 0


def test_static_without_a_transform_shows_the_usage(graph: LiveGraph, shell: Shell) -> None:
    assert "write X Y Z YAW PITCH ROLL PARENT CHILD" in shell.failure("tf", "static", "1", "2")
    assert "'--frequency' is not a ROS name" in shell.failure("tf", "static", "--frequency")
