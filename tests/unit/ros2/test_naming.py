"""Names as ROS 2 and its middlewares spell them."""

from __future__ import annotations

import pytest

from rostether.errors import InvalidNameError
from rostether.ros2.naming import (
    dds_name,
    logger_name,
    type_of_dds_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)


@pytest.mark.parametrize(
    ("name", "dds"),
    [
        ("std_msgs/msg/String", "std_msgs::msg::dds_::String_"),
        ("std_srvs/srv/SetBool", "std_srvs::srv::dds_::SetBool_"),
        ("std_srvs/srv/SetBool_Request", "std_srvs::srv::dds_::SetBool_Request_"),
    ],
)
def test_type_names_are_converted_in_both_directions(name: str, dds: str) -> None:
    assert dds_name(name) == dds
    assert type_of_dds_name(dds) == name


@pytest.mark.parametrize(
    "name",
    ["", "String", "std_msgs::msg::String_", "a::msg::dds_::B", "a::msg::dds_::B/C_", "a::x::dds_::B_"],
)
def test_invalid_type_names_give_an_empty_string(name: str) -> None:
    assert type_of_dds_name(name) == ""


@pytest.mark.parametrize(("node", "logger"), [("/board", "board"), ("/lab/robot/board", "lab.robot.board")])
def test_a_logger_has_the_name_of_its_node(node: str, logger: str) -> None:
    assert logger_name(node) == logger


def test_valid_names_are_accepted() -> None:
    assert validate_node_name("/ns/node_1") == "/ns/node_1"
    assert validate_node_name("node") == "/node"
    assert validate_namespace("/") == "/"
    assert validate_namespace("/a/b") == "/a/b"
    assert validate_topic_name("/a/_b") == "/a/_b"
    assert validate_topic_name("/" + "a" * 246)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("/", "empty after the last '/'"),
        ("", "empty after the last '/'"),
        ("/a/", "empty after the last '/'"),
        ("/a b", "' ' is not allowed"),
        ("/1a", "'1a' starts with a digit"),
        ("/1a/b", "'1a' starts with a digit"),
        ("//a", "'//' is not allowed"),
        ("/a-b", "'-' is not allowed"),
        ("/" + "a" * 256, "longer than 255 characters"),
        ("/" + "a" * 245 + "/b", "longer than 245 characters"),
        ("/\n" * 500, "'\\n' is not allowed"),
    ],
)
def test_errors_say_why_a_node_name_is_invalid(name: str, says: str) -> None:
    if name.endswith("\n"):
        name += "x"
    with pytest.raises(InvalidNameError) as error:
        validate_node_name(name)
    assert says in str(error.value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 300


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("a", "starts with '/'"),
        ("", "starts with '/'"),
        ("/", "it ends with '/'"),
        ("/a/", "it ends with '/'"),
        ("/a//b", "'//' is not allowed"),
        ("/a/2", "'2' starts with a digit"),
        ("/é", "'é' is not allowed"),
        ("/" + "a" * 247, "longer than 247 characters"),
    ],
)
def test_errors_say_why_a_topic_name_is_invalid(name: str, says: str) -> None:
    with pytest.raises(InvalidNameError) as error:
        validate_topic_name(name)
    assert says in str(error.value)
