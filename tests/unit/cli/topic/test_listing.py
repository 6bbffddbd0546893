from __future__ import annotations

import threading
from pathlib import Path

import pytest

from rostether.cli.shell.own_command import CALLED_AS_VARIABLE
from rostether.cli.topic.ros1_chosen_topic import choose_topic
from rostether.graph.joint_marks import MARK_TYPE, new_joint_mark
from rostether.graph.ports import TopicEntry
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.msgdef.registry import Registry
from rostether.ros1.node.node import Ros1Graph
from rostether.serde.store import TypeStore
from unit.cli.command_shell import STORE, LiveGraph, Shell

RANGE = STORE.registry.message_type("sensor_msgs/Range")
EMPTY = STORE.registry.message_type("std_msgs/Empty")


@pytest.fixture
def board(graph: LiveGraph) -> Ros1Graph:
    node = graph.node("board")
    graph.do(node.advertise("/ultrasound", RANGE))
    graph.do(node.advertise("/rear/ultrasound", RANGE))
    graph.do(node.subscribe("/toggle_led", EMPTY, lambda _: None))
    graph.do(node.subscribe("/anything", ANY_MESSAGE, lambda _: None))
    return node


def test_list(board: Ros1Graph, shell: Shell) -> None:
    assert shell.output("topic", "list") == "/anything\n/rear/ultrasound\n/rosout\n/toggle_led\n/ultrasound\n"
    assert shell.output("topic", "list", "-s") == "/anything\n/toggle_led\n"
    assert shell.output("topic", "list", "-p") == "/rear/ultrasound\n/rosout\n/ultrasound\n"
    assert shell.output("topic", "list", "rear") == "/rear/ultrasound\n"
    assert "give one of -p and -s, not both" in shell.failure("topic", "list", "-s", "-p", code=2)


def test_list_verbose(graph: LiveGraph, board: Ros1Graph, shell: Shell) -> None:
    graph.do(graph.node("second").advertise("/ultrasound", RANGE))
    assert shell.output("topic", "list", "-v").splitlines() == [
        "",
        "Published topics:",
        " * /rear/ultrasound [sensor_msgs/Range] 1 publisher",
        " * /rosout [rosgraph_msgs/Log] 2 publishers",
        " * /ultrasound [sensor_msgs/Range] 2 publishers",
        "",
        "Subscribed topics:",
        " * /anything [unknown type] 1 subscriber",
        " * /toggle_led [std_msgs/Empty] 1 subscriber",
        "",
    ]
    assert "Published" not in shell.output("topic", "list", "-v", "-s")
    assert "Subscribed" not in shell.output("topic", "list", "-v", "-p")


def test_list_by_host(board: Ros1Graph, shell: Shell) -> None:
    lines = shell.output("topic", "list", "--host", "rear").splitlines()
    assert lines == ["Host [127.0.0.1]:", "  /rear/ultrasound"]


def test_list_for_scripts(board: Ros1Graph, shell: Shell) -> None:
    records = {record["topic"]: record for record in shell("topic", "list", "--json").records}
    assert records["/ultrasound"] == {
        "topic": "/ultrasound",
        "type": "sensor_msgs/Range",
        "publishers": ["/board"],
        "subscribers": [],
    }
    assert records["/anything"]["type"] is None


def test_marks_of_relays_and_joint_boards_are_not_listed(graph: LiveGraph, shell: Shell) -> None:
    graph.do(graph.node("both").advertise(new_joint_mark(), MARK_TYPE))
    assert "/rostether/" not in shell.output("topic", "list")


def test_info(graph: LiveGraph, board: Ros1Graph, shell: Shell) -> None:
    assert shell.output("topic", "info", "ultrasound") == (
        f"Type: sensor_msgs/Range\n\nPublishers: \n * /board ({board.node_uri})\n\nSubscribers: None\n\n\n"
    )
    assert shell("topic", "info", "--json", "/toggle_led").records == [
        {
            "topic": "/toggle_led",
            "type": "std_msgs/Empty",
            "publishers": [],
            "subscribers": [{"node": "/board", "uri": board.node_uri}],
        }
    ]
    assert "`rostether topic list`" in shell.failure("topic", "info", "/nope")


def test_type(board: Ros1Graph, shell: Shell) -> None:
    assert shell.output("topic", "type", "/ultrasound") == "sensor_msgs/Range\n"
    assert shell.output("topic", "type", "/ultrasound/range") == "sensor_msgs/Range range float32\n"
    assert (
        shell.output("topic", "type", "/ultrasound/header/stamp") == "sensor_msgs/Range header/stamp time\n"
    )
    assert "has no publisher and no subscriber" in shell.failure("topic", "type", "/ultrasound/nope")
    assert "has no publisher and no subscriber" in shell.failure("topic", "type", "/anything")


def test_the_type_of_a_field_is_searched_beside_the_event_loop(
    board: Ros1Graph, shell: Shell, tmp_path: Path, searching_threads: list[threading.Thread]
) -> None:
    shell.output("topic", "type", "--msg-path", str(tmp_path), "/ultrasound/range")
    assert [each.name for each in searching_threads] == ["definitions"] * 2


def test_find(board: Ros1Graph, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    assert shell.output("topic", "find", "sensor_msgs/Range") == "/rear/ultrasound\n/ultrasound\n"
    assert shell("topic", "find", "--json", "std_msgs/Empty").records == [{"topic": "/toggle_led"}]
    assert shell.output("topic", "find", "std_msgs/Bool") == ""
    monkeypatch.setenv(CALLED_AS_VARIABLE, "rostopic")
    assert shell.output("topic", "find", "std_msgs/Bool") == "\n"


def test_without_a_master_the_next_step_is_named(shell: Shell) -> None:
    assert shell.failure("topic", "list") == (
        "no ROS master answers at http://127.0.0.1:9; start one with `rostether core` or `rostether serve`, "
        "or set ROS_MASTER_URI"
    )


@pytest.mark.parametrize(
    ("name", "topic", "field"),
    [
        ("/scan", "/scan", ""),
        ("/scan/", "/scan", ""),
        ("/scan/ranges", "/scan", "ranges"),
        ("/scan/ranges[3]", "/scan", "ranges[3]"),
        ("/scan/header/stamp", "/scan/header", "stamp"),
        # A topic with the name of a field of another topic is the topic.
        ("/scan/header", "/scan/header", ""),
        # A type that is not known here may have any field.
        ("/odd/x/y", "/odd", "x/y"),
        ("/scan/nope", "", ""),
        ("/anything", "", ""),
    ],
)
def test_what_a_name_means(name: str, topic: str, field: str) -> None:
    topics = [
        TopicEntry("/scan", "sensor_msgs/LaserScan", ("/a",), ()),
        TopicEntry("/scan/header", "std_msgs/Header", ("/a",), ()),
        TopicEntry("/odd", "my_robot/Odd", ("/a",), ()),
        TopicEntry("/anything", "*", (), ("/a",)),
    ]
    chosen = choose_topic(name, topics, TypeStore(Registry()))
    assert (chosen.topic, chosen.field) == (topic, field) if chosen is not None else topic == ""
