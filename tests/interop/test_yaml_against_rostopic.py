"""Printed messages equal rostopic's output byte for byte; arguments give the same messages as with genpy."""

from __future__ import annotations

import functools
import itertools
from typing import Any

import pytest

from interop.genpy_oracle import as_bytes, as_text, ask_genpy
from rostether.errors import SerializationError
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.csv_print import csv_header, csv_row
from rostether.serde.field_path import FieldPath
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.serde.yaml_form import parse_values
from rostether.serde.yaml_print import EchoStyle, format_message, format_value
from unit.serde.random_messages import RandomMessages

STORE = TypeStore(Registry())
NOW = Time(1700000123, 456)
PACKAGES = [
    "std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs", "diagnostic_msgs", "tf2_msgs", "trajectory_msgs",
    "visualization_msgs", "actionlib_msgs", "rosgraph_msgs", "shape_msgs", "stereo_msgs",
]  # fmt: skip
TYPES = [name for package in PACKAGES for name in STORE.registry.messages(package)]

YAML_STYLES: list[dict[str, Any]] = [
    {"nostr": no_strings, "noarr": no_arrays, "offset": offset, "width": width, "plot": False}
    for no_strings, no_arrays, offset, width in [
        (False, False, False, None),
        (False, True, False, None),
        (True, False, True, None),
        (True, True, False, 4),
        (False, False, True, 12),
        (False, False, False, 2),
    ]
]
PLOT_STYLES: list[dict[str, Any]] = [
    {"nostr": no_strings, "noarr": no_arrays, "offset": offset, "width": None, "plot": True}
    for no_strings, no_arrays, offset in itertools.product((False, True), repeat=3)
]
PATHS = [
    ("std_msgs/String", "/data"),
    ("std_msgs/Header", "/stamp"),
    ("std_msgs/Header", "/stamp/"),
    ("geometry_msgs/PoseStamped", "/pose"),
    ("geometry_msgs/PoseStamped", "/pose/position/x"),
    ("geometry_msgs/PoseWithCovariance", "/covariance"),
    ("geometry_msgs/PoseWithCovariance", "/covariance[3]"),
    ("geometry_msgs/PoseWithCovariance", "/covariance[-1]"),
    ("geometry_msgs/PoseWithCovariance", "/covariance[2:9:3]"),
    ("tf2_msgs/TFMessage", "/transforms"),
    ("tf2_msgs/TFMessage", "/transforms[:]"),
    ("tf2_msgs/TFMessage", "/transforms[:]/header/frame_id"),
    ("tf2_msgs/TFMessage", "/transforms[::2]/transform/rotation/w"),
    ("sensor_msgs/JointState", "/name"),
    ("sensor_msgs/JointState", "/position[:2]"),
    ("diagnostic_msgs/DiagnosticArray", "/status[:]/values[:]/key"),
]


def style_of(request: dict[str, Any]) -> EchoStyle:
    return EchoStyle(request["noarr"], request["nostr"], NOW if request["offset"] else None, request["width"])


def printed(value: Any, request: dict[str, Any], path: FieldPath | None) -> str:
    """Return the complete output for one message, as of `rostopic echo`."""
    style = style_of(request)
    if request["plot"]:
        return f"{csv_header(value, style)}\n{csv_row(value, NOW, style)}\n"
    text = format_message(value, style) if path is None else format_value(value, path.type, style)
    return f"{text}\n---\n"


@functools.cache
def echo_cases() -> dict[str, list[tuple[Message, dict[str, Any], Any]]]:
    """Return (message, request, rostopic's answer) by type, in every style, including for values that genpy
    changes.
    """
    cases = []
    for name in TYPES:
        codec = STORE.codec(name)
        for seed, styles in ((1, YAML_STYLES), (2, YAML_STYLES[:3]), (3, PLOT_STYLES), (4, PLOT_STYLES[:2])):
            message = RandomMessages(seed, wild=seed % 2 == 0).message(codec)
            request = {"task": "echo", "type": name, "payload": as_text(codec.encode(message))}
            cases += [(message, request | style) for style in styles]
    answers = ask_genpy([request for _, request in cases])
    found: dict[str, list[tuple[Message, dict[str, Any], Any]]] = {}
    for (message, request), answer in zip(cases, answers, strict=True):
        found.setdefault(request["type"], []).append((message, request, answer))
    return found


@pytest.mark.parametrize("name", TYPES)
def test_echo(name: str) -> None:
    for message, request, answer in echo_cases()[name]:
        assert answer["problem"] == ""
        assert printed(message, request, None) == answer["text"]


@functools.cache
def selections() -> list[tuple[Any, dict[str, Any], FieldPath, Any]]:
    cases = []
    for name, text in PATHS:
        codec = STORE.codec(name)
        path = FieldPath(codec, text)
        for seed in range(4):
            message = RandomMessages(seed).message(codec)
            request = {"task": "echo", "type": name, "payload": as_text(codec.encode(message)), "path": text}
            # rostopic shortens selected elements like the array, and does not plot lists of lists.
            plots = PLOT_STYLES[:2] if text.count("[") < 2 else []
            for style in (*YAML_STYLES[:1], *YAML_STYLES[4:], *plots):
                cases.append((path.read(message), request | style, path))
    answers = ask_genpy([request for _, request, _ in cases])
    return [(*case, answer) for case, answer in zip(cases, answers, strict=True)]


@pytest.mark.parametrize(("name", "text"), PATHS)
def test_echo_of_a_field(name: str, text: str) -> None:
    compared = 0
    for value, request, path, answer in selections():
        if request["type"] == name and request["path"] == text and not answer["problem"]:
            assert printed(value, request, path) == answer["text"]
            compared += 1
    assert compared


ARGUMENTS: list[tuple[str, list[str]]] = [
    ("std_msgs/Byte", ["1"]),
    ("std_msgs/Byte", ["-128"]),
    ("std_msgs/UInt8", ["{data: 255}"]),
    ("std_msgs/String", ["hello"]),
    ("std_msgs/String", ["data: 'hi'"]),
    ("std_msgs/String", ["'5'"]),
    ("std_msgs/String", ["{data: }"]),
    ("std_msgs/String", ["data: |\n  two\n  lines\n"]),
    ("std_msgs/Bool", ["true"]),
    ("std_msgs/Bool", ["no"]),
    ("std_msgs/Bool", ["1"]),
    ("std_msgs/Int32", ["-5"]),
    ("std_msgs/Int64", ["0x10"]),
    ("std_msgs/Float64", ["1"]),
    ("std_msgs/Float64", ["-1.5e+3"]),
    ("std_msgs/Float64", [".inf"]),
    ("std_msgs/Float64", [".nan"]),
    ("std_msgs/Time", ["now"]),
    ("std_msgs/Time", ["{data: now}"]),
    ("std_msgs/Time", ["{secs: 1, nsecs: 5}"]),
    ("std_msgs/Time", ["{data: {secs: 1, nsecs: 5}}"]),
    ("std_msgs/Time", ["[1, 5]"]),
    ("std_msgs/Time", ["1500000000"]),
    ("std_msgs/Duration", ["-1500000000"]),
    ("std_msgs/Duration", ["{data: {secs: -2}}"]),
    ("std_msgs/Empty", []),
    ("std_msgs/Empty", ["{}"]),
    ("std_msgs/Header", ["1", "now", "map"]),
    ("std_msgs/Header", ["{stamp: now, frame_id: map}"]),
    ("std_msgs/ColorRGBA", ["1", "0.5", "0", "1"]),
    ("std_msgs/UInt8MultiArray", ["{data: [1, 2, 3]}"]),
    ("std_msgs/UInt8MultiArray", ["{data: !!binary AQID}"]),
    ("std_msgs/UInt8MultiArray", ["{layout: {dim: [{label: a, size: 1, stride: 1}]}, data: []}"]),
    ("geometry_msgs/Twist", ["{linear: {x: 0.2}}"]),
    ("geometry_msgs/Twist", ["[0.2, 0, 0]", "[0, 0, 1]"]),
    ("geometry_msgs/Twist", ["{linear: [1, 2, 3]}"]),
    ("geometry_msgs/Twist", ["linear:\n  x: 2.0\n  y: 0.0\n  z: 0.0\nangular: {z: -1.8}\n"]),
    ("geometry_msgs/PoseStamped", ["{header: auto, pose: {orientation: {w: 1}}}"]),
    ("geometry_msgs/PoseStamped", ["{header: {stamp: now}}"]),
    ("geometry_msgs/PoseStamped", ["auto", "[[1, 2, 3], [0, 0, 0, 1]]"]),
    ("geometry_msgs/Polygon", ["[[1, 2, 3], {x: 4}]"]),
    ("geometry_msgs/Polygon", ["{points: [{x: 1}, [4, 5, 6]]}"]),
    ("sensor_msgs/JointState", ["{name: [a, b], position: [1, 2.5]}"]),
    ("sensor_msgs/Imu", ["{orientation_covariance: [1, 2, 3, 4, 5, 6, 7, 8, 9]}"]),
    ("sensor_msgs/Image", ["{data: [0, 255]}"]),
    ("trajectory_msgs/JointTrajectory", ["{points: [{positions: [1], time_from_start: {secs: 1}}]}"]),
    ("trajectory_msgs/JointTrajectory", ["{points: [{positions: [1], time_from_start: 2000000000}]}"]),
    ("tf2_msgs/TFMessage", ["{transforms: [{header: auto, child_frame_id: b}]}"]),
    # Arguments that both refuse.
    ("std_msgs/Byte", ["128"]),
    ("std_msgs/Byte", ["1.5"]),
    ("std_msgs/Byte", ["one"]),
    ("std_msgs/Byte", ["1", "2"]),
    ("std_msgs/Byte", []),
    ("std_msgs/UInt8", ["-1"]),
    ("std_msgs/String", ["5"]),
    ("std_msgs/String", ["{dta: x}"]),
    ("std_msgs/String", ["{data: [a]}"]),
    ("std_msgs/Empty", ["1"]),
    ("std_msgs/Float64", ["abc"]),
    ("std_msgs/Time", ["later"]),
    ("std_msgs/Time", ["1.5"]),
    ("std_msgs/Time", ["-1"]),
    ("std_msgs/Header", ["1", "now"]),
    ("std_msgs/Header", ["{stamp: auto}"]),
    ("geometry_msgs/Twist", ["{linear: {w: 1}}"]),
    ("geometry_msgs/Twist", ["{linear: 1}"]),
    ("geometry_msgs/Twist", ["{linear: [1, 2]}"]),
    ("geometry_msgs/Twist", ["{linear: auto}"]),
    ("geometry_msgs/Polygon", ["{points: {x: 1}}"]),
    ("sensor_msgs/Imu", ["{orientation_covariance: [1, 2]}"]),
    ("sensor_msgs/JointState", ["{position: [a]}"]),
    ("sensor_msgs/JointState", ["{name: abc}"]),
    ("geometry_msgs/Twist", ["{linear: {x: 1}"]),
]


@functools.cache
def fill_answers() -> list[Any]:
    return ask_genpy([{"task": "fill", "type": name, "arguments": args} for name, args in ARGUMENTS])


@pytest.mark.parametrize(
    "case", range(len(ARGUMENTS)), ids=lambda case: " ".join(map(str, ARGUMENTS[case][1]))[:40]
)
def test_arguments(case: int) -> None:
    name, arguments = ARGUMENTS[case]
    answer = fill_answers()[case]
    codec = STORE.codec(name)
    if "error" in answer:
        with pytest.raises(SerializationError) as error:
            codec.encode(parse_values(codec, arguments, now=lambda: NOW))
        assert "\n" not in str(error.value)
    else:
        assert codec.encode(parse_values(codec, arguments, now=lambda: NOW)) == as_bytes(answer["payload"])
