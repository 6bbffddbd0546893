from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.graph.ports import ParamValue
from rostether.robot.static_transforms import parse_static_transform, static_transform_of
from rostether.robot.transform import quaternion_from_rpy


def test_yaw_comes_before_pitch_and_roll() -> None:
    static = parse_static_transform(["1", "-2", "3", "0.1", "0.2", "0.3", "world", "laser"])
    assert (static.parent, static.child, static.period_s) == ("world", "laser", None)
    assert static.transform.translation == (1.0, -2.0, 3.0)
    assert static.transform.rotation == quaternion_from_rpy(0.3, 0.2, 0.1)


def test_a_quaternion_is_read_as_typed() -> None:
    static = parse_static_transform(["0", "0", "0", "0.5", "-0.5", "0.5", "0.5", "world", "laser"])
    assert static.transform.rotation == (0.5, -0.5, 0.5, 0.5)


@pytest.mark.parametrize(
    ("options", "positions"),
    [
        ("--x 1 --yaw -0.5 --frame-id world --child-frame-id laser", "1 0 0 -0.5 0 0 world laser"),
        ("--child-frame-id laser --qz 1 --qw 0 --frame-id world --z 2", "0 0 2 0 0 1 0 world laser"),
        ("--frame-id world --child-frame-id laser --qx 0", "0 0 0 0 0 0 1 world laser"),
    ],
)
def test_the_options_of_ros2(options: str, positions: str) -> None:
    assert parse_static_transform(options.split()) == parse_static_transform(positions.split())


@pytest.mark.parametrize("words", ["0 0 0 0 0 0 a b 100", "0 0 0 0 0 0 1 a b 100"])
def test_a_period_is_in_milliseconds(words: str) -> None:
    static = parse_static_transform(words.split())
    assert (static.parent, static.child, static.period_s) == ("a", "b", 0.1)


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        ("", "0 arguments"),
        ("0 0 0 0 0 0 a", "7 arguments"),
        ("0 0 0 0 0 x a b", "'x' is not a number"),
        ("0 0 0 0 0 inf a b", "'inf' is not a number"),
        ("0 0 0 0 0 0 a a", "are both 'a'; give two different frames"),
        ("0 0 0 0 0 0 2 a b", "length 1"),
        ("0 0 0 0 0 0 a b -5", "positive"),
        ("--x 1 --frame-id a", "has no --child-frame-id; add"),
        ("--x 1 --frame_id a --child-frame-id b", "'--frame_id' is not an option .*; known: --x, "),
        ("--frame-id a --child-frame-id b --x", "--x has no value"),
        ("--yaw 1 --qw 1 --frame-id a --child-frame-id b", "a quaternion or angles"),
        ("--x one --frame-id a --child-frame-id b", "'one' is not a number"),
        ("0 0 0 0 0 0 a b often", "'often' is not a number"),
    ],
)
def test_invalid_arguments_are_refused(words: str, reported: str) -> None:
    with pytest.raises(ConfigError, match=reported):
        parse_static_transform(words.split())


def test_a_transform_can_be_a_parameter() -> None:
    turn: dict[str, ParamValue] = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    static = static_transform_of(
        {
            "header": {"frame_id": "world"},
            "child_frame_id": "laser",
            "transform": {"translation": {"x": 1, "y": 2.0, "z": 3.0}, "rotation": turn},
        },
        "/laser",
    )
    assert (static.parent, static.child, static.transform.translation) == ("world", "laser", (1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    "value", [None, 5, {}, {"header": {}, "transform": {"translation": 1, "rotation": 2}}]
)
def test_other_parameters_are_refused(value: object) -> None:
    with pytest.raises(ConfigError, match="/laser"):
        static_transform_of(value, "/laser")  # type: ignore[arg-type]
