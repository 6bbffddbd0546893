from __future__ import annotations

from pathlib import Path

import pytest

from rostether.firmware.diagnostics import explain
from rostether.firmware.sketch import open_sketch
from unit.firmware.sketches import write_sketch


def _explained(folder: Path, text: str, output: str) -> str:
    return explain(output, open_sketch(write_sketch(folder, "S", text)))


@pytest.mark.parametrize(
    ("text", "place", "rest"),
    [
        ("#include <ros.h> #include <std_msgs/Empty.h>\n", "1:18", "#include <std_msgs/Empty.h>"),
        ("int a;\n#include <ros.h> ros::NodeHandle nh;\n", "2:18", "ros::NodeHandle nh;"),
        ("#define A 1 #define B 2\n", "1:13", "#define B 2"),
        ("// My sketch void setup() { } void loop() { }\n", "1:14", "void setup() { } void loop() {"),
    ],
)
def test_lines_that_a_web_page_joined_are_named(tmp_path: Path, text: str, place: str, rest: str) -> None:
    first = _explained(tmp_path, text, "S.ino:9:1: error: nonsense").splitlines()[0]
    assert f"S.ino:{place}: error: a web page joined several lines into this one" in first
    assert first.endswith(f"start a new line before `{rest}`")


def test_correct_lines_are_not_named(tmp_path: Path) -> None:
    text = (
        "#include <ros.h> // the library\n#include <a.h> /* another */\n#define A(x) x\n"
        'void setup() { f("// void loop() {"); } // void has no value\nvoid loop() {}\n'
    )
    assert "web page" not in _explained(tmp_path, text, "S.ino:9:1: error: nonsense")


def test_messages_as_a_base_class_have_a_hint(tmp_path: Path) -> None:
    output = (
        "S.ino:8:5: note:   no known conversion for argument 2 from 'std_msgs::Int32*' to 'const ros::Msg*'\n"
    )
    assert "generated messages are not ros::Msg" in _explained(tmp_path, "ros::Msg* m;", output * 2)


@pytest.mark.parametrize("quotes", ["''", "\u2018\u2019"])
def test_pins_of_the_opencr_have_a_hint(tmp_path: Path, quotes: str) -> None:
    name = "BDPIN_LED_USER_1".join(quotes)
    output = f"S.ino:3:8: error: {name} was not declared in this scope\n" * 2
    text = _explained(tmp_path, "void setup() {}\n", output)
    assert text.count("note:") == 1
    assert "build with --board opencr, or name a pin here: -D BDPIN_LED_USER_1=13" in text


@pytest.mark.parametrize(
    "error",
    [
        "error: cannot convert \u2018StringSumHelper\u2019 to \u2018M::_data_type {aka const char*}\u2019",
        "note:   no known conversion for argument 1 from 'String' to 'const char*'",
    ],
)
def test_a_string_object_in_a_message(tmp_path: Path, error: str) -> None:
    assert "text.c_str()" in _explained(tmp_path, "text.data = String(5);", f"S.ino:6:24: {error}\n")
    assert "text.c_str()" not in _explained(tmp_path, "String a = 5;", "cannot convert 'int' to 'String'\n")


def test_a_flash_text_in_a_message(tmp_path: Path) -> None:
    output = (
        "S.ino:6:24: error: cannot convert 'const __FlashStringHelper*' to "
        "'std_msgs::String::_data_type {aka const char*}' in assignment\n"
    )
    assert "remove F()" in _explained(tmp_path, 'text.data = F("hello");', output)
