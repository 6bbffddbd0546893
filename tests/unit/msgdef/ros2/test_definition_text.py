from __future__ import annotations

import pytest

from rostether.msgdef.definition_files import Kind
from rostether.msgdef.full_text import split_full_text
from rostether.msgdef.ros2.definition_text import full_text, message_text
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.parse import parse_message

DEFINITIONS = Ros2Definitions()

TEXT = """int8 LOW=-1
string GREETING="it's \\"fine\\""
bool IS_ON=true
float32 HALF=0.5
string<=5 name "a b"
string<=5[<=3] names ["x", "y, z"]
uint8[4] parts [1, 2, 3, 4]
float64[] values
std_msgs/Header header
geometry_msgs/Point[2] ends
bool is_ready true
"""


def test_the_text_of_a_message_is_read_as_the_message() -> None:
    message = parse_message(TEXT, package="arm_msgs", name="Gripper")
    assert parse_message(message_text(message), package="arm_msgs", name="Gripper") == message


@pytest.mark.parametrize("name", DEFINITIONS.names(Kind.MESSAGE))
def test_every_message_is_read_back_from_its_full_text(name: str) -> None:
    message = DEFINITIONS.message(name)
    package, _, short_name = name.partition("/msg/")
    assert parse_message(message_text(message), package=package, name=short_name) == message
    parts = split_full_text(name, full_text(message, DEFINITIONS))
    for part, text in parts.items():
        package, _, short_name = part.replace("/msg/", "/").partition("/")
        expected = DEFINITIONS.message(f"{package}/msg/{short_name}")
        assert parse_message(text, package=package, name=short_name) == expected
