from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import UnknownTypeError
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.registry import Registry
from rostether.msgdef.unknown_type import example_name

HOW = "give its folder with --msg-path DIR or put it on ROS_PACKAGE_PATH"


def text_for_message(name: str, *paths: Path) -> str:
    with pytest.raises(UnknownTypeError) as raised:
        Registry(paths).message(name)
    return str(raised.value)


def test_a_missing_package_is_named_with_what_to_do() -> None:
    assert text_for_message("my_arm/ServoAngles") == (
        f"no package 'my_arm' is known for my_arm/ServoAngles; {HOW}"
    )


def test_a_misspelt_package_is_corrected() -> None:
    assert "did you mean geometry_msgs?" in text_for_message("geometry_msg/Twist")


def test_a_misspelt_message_is_corrected() -> None:
    text = text_for_message("std_msgs/Strin")
    assert text.startswith("package 'std_msgs' has no message 'Strin'; did you mean std_msgs/String?")
    assert text.endswith(HOW)


def test_a_message_without_similar_names() -> None:
    assert text_for_message("std_msgs/Xyzzy") == (
        f"package 'std_msgs' has no message 'Xyzzy'; if a newer version has it, {HOW}"
    )


def test_a_type_of_the_other_kind_is_recognized() -> None:
    assert text_for_message("std_srvs/SetBool") == "std_srvs/SetBool is a service, not a message"
    with pytest.raises(UnknownTypeError, match="std_msgs/String is a message, not a service"):
        Registry().service("std_msgs/String")


def test_services_are_corrected_too() -> None:
    with pytest.raises(UnknownTypeError, match="has no service 'SetBol'; did you mean std_srvs/SetBool"):
        Registry().service("std_srvs/SetBol")


def test_the_users_packages_count(tmp_path: Path) -> None:
    (tmp_path / "my_msgs").mkdir()
    (tmp_path / "my_msgs" / "Wheel.msg").write_text("int8 x")
    assert "did you mean my_msgs/Wheel?" in text_for_message("my_msgs/Weel", tmp_path)


@pytest.mark.parametrize(
    ("kind", "name", "example"),
    [
        (Kind.MESSAGE, "Int32", "std_msgs/Int32"),
        (Kind.MESSAGE, "Twist", "geometry_msgs/Twist"),
        (Kind.SERVICE, "Trigger", "std_srvs/Trigger"),
        (Kind.MESSAGE, "../x", "std_msgs/String"),
        (Kind.SERVICE, "Nothing", "std_srvs/SetBool"),
    ],
)
def test_a_type_without_its_package(kind: Kind, name: str, example: str) -> None:
    assert example_name(kind, name) == example
