from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.names.remap import Arguments, parse_arguments


def test_every_argument_is_classified() -> None:
    parsed = parse_arguments(
        [
            "/dev/ttyACM0",
            "_baud:=115200",
            "__name:=opencr",
            "__ns:=/robot",
            "a:=b",
            "--flag",
            "/x/y:=~z",
            "~p:=q",
        ]
    )
    assert parsed == Arguments(
        remappings={"a": "b", "/x/y": "~z", "~p": "q"},
        private_params={"baud": 115200},
        special={"__name": "opencr", "__ns": "/robot"},
        rest=["/dev/ttyACM0", "--flag"],
    )


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("57600", 57600),
        ("0.5", 0.5),
        ("true", True),
        ("/dev/ttyACM0", "/dev/ttyACM0"),
        ("[1, 2]", [1, 2]),
        ("{a: 1}", {"a": 1}),
        ("'5'", "5"),
        ("a:=b", "a:=b"),
    ],
)
def test_private_parameters_are_yaml(text: str, value: object) -> None:
    assert parse_arguments([f"_p:={text}"]).private_params == {"p": value}


def test_all_special_names_are_known() -> None:
    keys = ["__name", "__ns", "__log", "__ip", "__hostname", "__master"]
    assert parse_arguments([f"{key}:=x" for key in keys]).special == dict.fromkeys(keys, "x")


def test_an_unknown_special_name_is_an_error_that_names_the_known() -> None:
    with pytest.raises(ConfigError, match=r"__nane.*__name:="):
        parse_arguments(["__nane:=x"])


@pytest.mark.parametrize("argument", ["a:=", ":=b", "_p:="])
def test_empty_sides_are_never_remappings(argument: str) -> None:
    parsed = parse_arguments([argument])
    assert not parsed.remappings
    assert not parsed.private_params


@pytest.mark.parametrize("argument", ["tcp://:11411", "a=b", "pty:/tmp/board", "-x", "", "a b:=c", "1:=2"])
def test_other_arguments_are_unchanged(argument: str) -> None:
    assert parse_arguments([argument]) == Arguments(rest=[argument])


def test_the_last_one_counts() -> None:
    parsed = parse_arguments(["a:=b", "_p:=1", "a:=c", "_p:=2"])
    assert parsed.remappings == {"a": "c"}
    assert parsed.private_params == {"p": 2}


@pytest.mark.parametrize("argument", ["a:=b c", "a:=b:=c", "a//b:=c"])
def test_a_remapping_to_no_name_is_an_error(argument: str) -> None:
    with pytest.raises(ConfigError, match="not a ROS name"):
        parse_arguments([argument])


def test_a_value_that_is_not_yaml_is_an_error_in_one_line() -> None:
    with pytest.raises(ConfigError, match="not YAML") as raised:
        parse_arguments(["_p:=[1, 2"])
    assert "\n" not in str(raised.value)
