from __future__ import annotations

import threading

import pytest

from rostether.cli.shell.output import warn
from rostether.cli.topic import ros1_chosen_topic
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from unit.cli.command_shell import STORE, LiveGraph, Shell
from unit.cli.talking import call, command_node, in_background, publish, shut_down

RANGES = [{"range": meters, "header": {"frame_id": "sonar", "stamp": {"secs": 5}}} for meters in (0.5, 2.0)]


def test_echo_prints_as_rostopic_does(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/ultrasound", "sensor_msgs/Range", *RANGES)
    assert shell.output("topic", "echo", "-n", "1", "ultrasound") == (
        "header: \n"
        "  seq: 0\n"
        "  stamp: \n"
        "    secs: 5\n"
        "    nsecs:         0\n"
        '  frame_id: "sonar"\n'
        "radiation_type: 0\n"
        "field_of_view: 0.0\n"
        "min_range: 0.0\n"
        "max_range: 0.0\n"
        "range: 0.5\n"
        "---\n"
    )


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["/r/range"], "0.5\n---\n2.0\n---\n"),
        (["-w", "6", "/r/range"], "0.5000\n---\n2.0000\n---\n"),
        (["--nostr", "/r/header/frame_id"], '"<string length: 5>"\n---\n"<string length: 5>"\n---\n'),
        (["-c", "/r/range"], "\033[2J\033[;H0.5\n---\n\033[2J\033[;H2.0\n---\n"),
        (["-c", "--json", "/r/range"], '{"value": 0.5}\n{"value": 2.0}\n'),
        (["-p", "/r/header/stamp"], "%time,field\nNOW,5000000000\nNOW,5000000000\n"),
    ],
)
def test_fields_and_forms(graph: LiveGraph, shell: Shell, arguments: list[str], expected: str) -> None:
    publish(graph, "/r", "sensor_msgs/Range", *RANGES)
    printed = shell.output("topic", "echo", "-n", "2", *arguments)
    if "-p" in arguments:
        header, *rows = printed.splitlines()
        printed = "\n".join([header, *(f"NOW,{row.partition(',')[2]}" for row in rows), ""])
    assert printed == expected


def test_rows_begin_with_the_header_s_stamp(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/r", "sensor_msgs/Range", *RANGES)
    lines = shell.output("topic", "echo", "-n", "2", "-p", "--nostr", "/r").splitlines()
    assert lines[0] == (
        "%time,field.header.seq,field.header.stamp,field.radiation_type,field.field_of_view,"
        "field.min_range,field.max_range,field.range"
    )
    assert lines[1] == "5000000000,0,5000000000,0,0.0,0.0,0.0,0.5"


def test_the_filter_counts_what_it_lets_through(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/r", "sensor_msgs/Range", *RANGES)
    printed = shell.output("topic", "echo", "-n", "1", "--filter", "m.range > 1", "/r/range")
    assert printed == "2.0\n---\n"


def test_a_wrong_filter_ends_the_command(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/r", "sensor_msgs/Range", *RANGES)
    assert "there is no .rnage; the fields are" in shell.failure(
        "topic", "echo", "--filter", "m.rnage > 1", "/r"
    )
    assert "not an expression" in shell.failure("topic", "echo", "--filter", "m.range >", "/r")


def test_a_type_that_is_unknown_here_is_learned_from_its_publisher(graph: LiveGraph, shell: Shell) -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("my_robot/Probe", "float32 depth\nuint8[] raw\n")
    codec = TypeStore(registry).codec("my_robot/Probe")
    node = graph.node("board")
    publisher = graph.do(node.advertise("/probe", registry.message_type("my_robot/Probe"), latch=True))
    call(graph, lambda: publisher.publish_raw([codec.encode({"depth": 1.5, "raw": [1, 2]})]))
    assert shell.output("topic", "echo", "-n", "1", "/probe") == "depth: 1.5\nraw: [1, 2]\n---\n"
    assert shell.output("topic", "echo", "-n", "1", "/probe/depth") == "1.5\n---\n"
    assert shell("topic", "echo", "-n", "1", "--json", "/probe").records == [{"depth": 1.5, "raw": [1, 2]}]
    assert "has no field 'nope'" in shell.failure("topic", "echo", "-n", "1", "/probe/nope")


def test_an_element_that_is_not_there_is_reported_once(graph: LiveGraph, shell: Shell) -> None:
    scans = [{"ranges": [1.0]}, {"ranges": [1.0]}, {"ranges": [1.0, 2.0]}]
    publish(graph, "/scan", "sensor_msgs/LaserScan", *scans)
    result = shell("topic", "echo", "-n", "1", "/scan/ranges[1]")
    assert (result.code, result.out) == (0, "2.0\n---\n")
    assert result.err.count("selects element 1 of 'ranges', which has 1") == 1


@pytest.fixture
def warned(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """An event that is set when the command has warned that it waits."""
    event = threading.Event()

    def warn_and_tell(text: str) -> None:
        warn(text)
        event.set()

    monkeypatch.setattr(ros1_chosen_topic, "warn", warn_and_tell)
    return event


def test_a_topic_that_is_not_there_yet_is_waited_for(
    graph: LiveGraph, shell: Shell, warned: threading.Event
) -> None:
    def appear() -> None:
        assert warned.wait(60)
        publish(graph, "/late", "std_msgs/Bool", {"data": True})

    in_background(appear)
    result = shell("topic", "echo", "-n", "1", "/late")
    assert (result.code, result.out) == (0, "data: True\n---\n")
    assert result.err == "WARNING: topic [/late] does not appear to be published yet\n"


def test_a_wrong_field_ends_the_command(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/r", "sensor_msgs/Range")
    error = shell.failure("topic", "echo", "/r/rnage")
    assert "in /r, sensor_msgs/Range has no field 'rnage'; it has header, " in error
    assert error.rstrip().endswith("did you mean range?")


def test_a_topic_below_a_topic_may_come_later(
    graph: LiveGraph, shell: Shell, warned: threading.Event
) -> None:
    publish(graph, "/r", "sensor_msgs/Range")
    publish(graph, "/r/raw", "std_msgs/Bool")

    def appear() -> None:
        assert warned.wait(60)
        publish(graph, "/r/later", "std_msgs/Bool", {"data": True})

    in_background(appear)
    assert shell("topic", "echo", "-n", "1", "/r/later").code == 0


def test_a_topic_of_a_similar_name_is_suggested(
    graph: LiveGraph, shell: Shell, warned: threading.Event
) -> None:
    publish(graph, "/ultrasound", "sensor_msgs/Range")

    def appear() -> None:
        assert warned.wait(60)
        publish(graph, "/ultrasond", "sensor_msgs/Range", {})

    in_background(appear)
    result = shell("topic", "echo", "-n", "1", "/ultrasond")
    assert "[/ultrasond] does not appear to be published yet; did you mean /ultrasound?" in result.err
    assert "did you mean /ultraso" in shell.failure("topic", "info", "/ultrasonnd")


def test_the_wait_for_a_topic_ends_when_the_node_is_shut_down(
    graph: LiveGraph, shell: Shell, warned: threading.Event
) -> None:
    def end() -> None:
        assert warned.wait(60)
        name = command_node(graph)
        assert name is not None
        shut_down(graph, name)

    in_background(end)
    assert "the node was shut down before topic /late was published" in shell.failure(
        "topic", "echo", "/late"
    )


def test_echo_ends_when_its_node_is_shut_down(graph: LiveGraph, shell: Shell) -> None:
    publisher = publish(graph, "/r", "sensor_msgs/Range", *RANGES)

    def end() -> None:
        graph.wait_until(lambda: publisher.subscriber_count > 0)
        name = command_node(graph)
        assert name is not None
        shut_down(graph, name)

    ending = in_background(end)
    assert shell("topic", "echo", "/r/range").code == 0
    ending.join(60)


def test_a_topic_without_publishers_is_reported(
    graph: LiveGraph, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    message_type = STORE.registry.message_type("std_msgs/Bool")
    graph.do(graph.node("listener").subscribe("/quiet", message_type, lambda _payloads: None))
    warned = threading.Event()
    warnings: list[str] = []

    def record(text: str) -> None:
        warnings.append(text)
        warned.set()

    def speak() -> None:
        warned.wait(60)
        talker = graph.node("talker")
        publisher = graph.do(talker.advertise("/quiet", message_type, latch=True))
        call(graph, lambda: publisher.publish_raw([b"\x01"]))

    monkeypatch.setattr("rostether.cli.topic.ros1_echo.SILENCE_WARNING_S", 0.0)
    monkeypatch.setattr("rostether.cli.topic.ros1_echo.warn", record)
    speaking = in_background(speak)
    assert "data: True" in shell.output("topic", "echo", "-n", "1", "/quiet")
    speaking.join(60)
    assert warnings == ["WARNING: topic [/quiet] has no publisher yet"]


def test_the_field_of_ros2_s_option(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/r", "sensor_msgs/Range", *RANGES)
    printed = shell.output("topic", "echo", "--once", "--field", "header.frame_id", "/r")
    assert printed == '"sonar"\n---\n'
