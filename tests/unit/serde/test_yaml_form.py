"""Arguments as users type them; test_yaml_against_rostopic compares with genpy."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rostether.errors import SerializationError
from rostether.msgdef.registry import Registry
from rostether.rostime import Duration, Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.serde.yaml_form import fill_message, load_arguments, parse_documents, parse_values
from unit.serde.definitions import store_of

STORE = TypeStore(Registry())
NOW = Time(1234, 5)


def parsed(name: str, *arguments: str) -> Message:
    return parse_values(STORE.codec(name), arguments, now=lambda: NOW)


def test_mapping_leaves_the_rest_zero() -> None:
    twist = parsed("geometry_msgs/Twist", "{linear: {x: 0.2}}")
    assert twist == STORE.codec("geometry_msgs/Twist").conform({"linear": {"x": 0.2}})


def test_values_in_order() -> None:
    twist = parsed("geometry_msgs/Twist", "[0.2, 0, 0]", "[0, 0, 1]")
    assert (twist.linear.x, twist.angular.z) == (0.2, 1.0)
    assert parsed("std_msgs/String", "hello").data == "hello"
    assert parsed("std_msgs/Int8", "-5").data == -5


def test_one_text_is_one_argument() -> None:
    assert parse_values(STORE.codec("std_msgs/String"), "data: hi", now=Time).data == "hi"


@pytest.mark.parametrize("arguments", [[], ["{}"], [""]])
def test_message_without_fields(arguments: list[str]) -> None:
    assert parsed("std_msgs/Empty", *arguments) == STORE.codec("std_msgs/Empty").message_class()


def test_now_and_auto() -> None:
    assert parsed("std_msgs/Time", "now").data == NOW
    pose = parsed("geometry_msgs/PoseStamped", "{header: auto}")
    assert (pose.header.stamp, pose.header.frame_id) == (NOW, "")
    times = store_of(Times="time[] at").codec("test/Times")
    assert parse_values(times, "{at: [now, 5]}", now=lambda: NOW).at == [NOW, Time(0, 5)]


def test_now_reads_the_clock_for_every_message() -> None:
    clock = iter([Time(1), Time(2)])
    codec, values = STORE.codec("std_msgs/Time"), load_arguments(["now"])
    filled = [fill_message(codec, values, now=lambda: next(clock)).data for _ in range(2)]
    assert filled == [Time(1), Time(2)]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1700000000123456789", Time(1700000000, 123456789)),
        ("{secs: 1, nsecs: 2}", Time(1, 2)),
        ("{data: [1, 2]}", Time(1, 2)),
        ("{data: }", Time()),
    ],
)
def test_times(text: str, value: Time) -> None:
    message = parsed("std_msgs/Time", text if "data" in text else f"{{data: {text}}}")
    assert message.data == value


def test_negative_duration() -> None:
    assert parsed("std_msgs/Duration", "-1").data == Duration(-1, 999999999)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),
        ("1.5E3", 1500.0),
        ("inf", math.inf),
        ("-inf", -math.inf),
        ("-.5e2", -50.0),
        ("-Infinity", -math.inf),
    ],
)
def test_floats_that_yaml_reads_as_texts(text: str, value: float) -> None:
    assert parsed("std_msgs/Float64", text).data == value


def test_nan() -> None:
    for text in ("nan", ".nan", "'NaN'"):
        assert math.isnan(parsed("std_msgs/Float32", text).data)


@pytest.mark.parametrize("text", ["[1, 2]", "!!binary AQI=", '"\\x01\\x02"'])
def test_bytes(text: str) -> None:
    assert parsed("std_msgs/UInt8MultiArray", f"{{data: {text}}}").data == b"\1\2"


def test_empty_values_are_zero() -> None:
    text = "{header: , name: , position: }"
    assert parsed("sensor_msgs/JointState", text) == STORE.codec("sensor_msgs/JointState").message_class()
    assert parsed("std_msgs/String", "").data == ""
    assert parsed("sensor_msgs/Image", "{data: }").data == b""


@pytest.mark.parametrize(
    ("name", "arguments", "text"),
    [
        (
            "geometry_msgs/Twist",
            ["{linear: {w: 1}}"],
            "geometry_msgs/Twist.linear has no field 'w'; it has x, y, z",
        ),
        ("std_msgs/String", ["{dta: 1}"], "std_msgs/String has no field 'dta'; it has data"),
        ("std_msgs/String", ["5"], "needs a string (put it in quotes: \"'5'\"), got 5"),
        ("std_msgs/String", [], "std_msgs/String needs 1 value (data), or a mapping, got 0"),
        ("std_msgs/Empty", ["1"], "std_msgs/Empty needs 0 values, or a mapping, got 1"),
        ("geometry_msgs/Twist", ["[1, 2, 3]"], "needs 2 values (linear, angular), or a mapping, got 1"),
        (
            "geometry_msgs/Twist",
            ["[1, 2]", "[1, 2, 3]"],
            "field 'linear' of geometry_msgs/Twist needs 3 values",
        ),
        (
            "geometry_msgs/Twist",
            ["{linear: auto}"],
            "'linear' of geometry_msgs/Twist needs a geometry_msgs/Vector3",
        ),
        (
            "std_msgs/Time",
            ["later"],
            "a time, as {secs: 1, nsecs: 5}, [1, 5], whole nanoseconds, or now, got 'later'",
        ),
        (
            "std_msgs/Duration",
            ["now"],
            "a duration, as {secs: 1, nsecs: 5}, [1, 5], whole nanoseconds, got 'now'",
        ),
        ("std_msgs/Time", ["-1"], "field 'data' of std_msgs/Time needs a time (secs and nsecs, each uint32)"),
        ("std_msgs/Float64", ["fast"], "field 'data' of std_msgs/Float64 needs a float64, got 'fast'"),
        ("std_msgs/Int32", ["1e3"], "needs an int32 (-2147483648 to 2147483647), got '1e3'"),
        ("sensor_msgs/JointState", ["{position: 1}"], "needs a list (float64[]), got 1"),
        (
            "std_msgs/Bool",
            ["maybe"],
            "field 'data' of std_msgs/Bool needs a bool (true or false), got 'maybe'",
        ),
        ("geometry_msgs/Twist", ["linear:", "{x:", "1}"], "put quotes around the message: 'linear: {x: 1}'"),
    ],
)
def test_mistakes(name: str, arguments: list[str], text: str) -> None:
    with pytest.raises(SerializationError) as error:
        parsed(name, *arguments)
    assert text in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "{a: 1",
        "[1, 2",
        "a: b: c",
        "{a: !!python/object:os.system x}",
        "2020-99-99",
        "\t",
        "[" * 900,
        "\0",
        "? [a]",
    ],
)
def test_texts_that_are_not_yaml(text: str) -> None:
    with pytest.raises(SerializationError) as error:
        parsed("std_msgs/String", text)
    assert "is not YAML" in str(error.value)
    assert "\n" not in str(error.value)


def test_list_that_contains_itself() -> None:
    with pytest.raises(SerializationError):
        parsed("geometry_msgs/Polygon", "{points: &a [*a]}")


def test_documents() -> None:
    text = "data: one\n---\n[two]\n---\n---\nthree\n"
    codec = STORE.codec("std_msgs/String")
    assert [message.data for message in parse_documents(codec, text, now=Time)] == ["one", "two", "three"]


def test_documents_before_a_mistake_are_read() -> None:
    documents = parse_documents(STORE.codec("std_msgs/String"), "one\n---\n{two]", now=Time)
    found: list[Any] = [next(documents).data]
    with pytest.raises(SerializationError, match="line 3"):
        found += documents
    assert found == ["one"]
