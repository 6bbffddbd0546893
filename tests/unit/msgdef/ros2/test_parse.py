"""Definitions of ROS 2: parsed as by rosidl, with positions in errors."""

from __future__ import annotations

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.ros2.parse import parse_message, parse_service
from rostether.msgdef.ros2.spec import Ros2Constant, Ros2Field, Ros2Message, Ros2Type


def parse(text: str) -> Ros2Message:
    return parse_message(text, package="my_msgs", name="Foo", file="Foo.msg")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("int32", Ros2Type("int32")),
        ("string<=10", Ros2Type("string", string_bound=10)),
        ("wstring", Ros2Type("wstring")),
        ("float64[9]", Ros2Type("float64", is_array=True, length=9)),
        ("byte[]", Ros2Type("byte", is_array=True)),
        ("char[<=5]", Ros2Type("char", is_array=True, bound=5)),
        ("string<=10[<=5]", Ros2Type("string", is_array=True, bound=5, string_bound=10)),
        ("Bar[2]", Ros2Type("my_msgs/msg/Bar", is_array=True, length=2)),
        ("std_msgs/Header", Ros2Type("std_msgs/msg/Header")),
    ],
)
def test_reads_types(text: str, expected: Ros2Type) -> None:
    (field,) = parse(f"{text} a_1\n").fields
    assert field == Ros2Field(expected, "a_1")
    assert str(expected) == text.replace("Bar", "my_msgs/msg/Bar").replace("std_msgs/", "std_msgs/msg/")


@pytest.mark.parametrize(
    ("text", "default"),
    [
        ("int8 a -2", -2),
        ("uint16 a 0x10", 16),
        ("bool a true", True),
        ("bool a 0", False),
        ("float32 a 1e3", 1000.0),
        ('string a "it is # no comment"', None),
        ('string a " x "  # a comment', " x "),
        ("string a 'it\\'s'", "it's"),
        ("string a plain words", "plain words"),
        ("int32[] a [1, 2,3]", (1, 2, 3)),
        ("int32[] a []", ()),
        ("float64[2] a [1, .5]", (1.0, 0.5)),
        ("string[] a ['a, b', \"c\", d]", ("a, b", "c", "d")),
        ("string[<=2] a ['', ' ']", ("", " ")),
        ("string[] a ['x',]", ("x",)),
        ("string[] a []", ()),
    ],
)
def test_reads_defaults(text: str, default: object) -> None:
    if default is None:
        # rosidl cuts at every '#', which leaves a lone quotation mark here.
        assert parse(text).fields[0].default == '"it is'
    else:
        assert parse(text).fields[0].default == default


def test_reads_constants_comments_and_blank_lines() -> None:
    message = parse("# head\n\nuint8 A=1\t# one\nstring NAME = 'x y'\n  float32 F_1=-.5\nint32\ta   # end\n")
    assert message.full_name == "my_msgs/msg/Foo"
    assert message.constants == (
        Ros2Constant("uint8", "A", 1),
        Ros2Constant("string", "NAME", "x y"),
        Ros2Constant("float32", "F_1", -0.5),
    )
    assert message.fields == (Ros2Field(Ros2Type("int32"), "a"),)


@pytest.mark.parametrize(
    ("text", "place", "says"),
    [
        ("int32", "1:1", "not 'type name'"),
        ("\nint32 frameId", "2:7", "not a field name"),
        ("int32 a__b", "1:7", "not a field name"),
        ("int32 a_", "1:7", "not a field name"),
        ("time stamp", "1:1", "ROS 2 has builtin_interfaces/Time"),
        ("foo a", "1:1", "not a built-in type or a message name"),
        ("my_msgs/msg/Foo a", "1:1", "not 'package/Name'"),
        ("My/Foo a", "1:1", "not 'package/Name'"),
        ("int32<=3 a", "1:1", "only string and wstring"),
        ("int32[0] a", "1:1", "at least 1"),
        ("string<=0 a", "1:1", "at least 1"),
        ("int32[99999999999999999999999] a", "1:1", "at most 16777216"),
        ("int32[ a", "1:1", "not a type"),
        ("int32 a\nint8 a", "2:6", "declared twice"),
        ("Bar a 1", "1:7", "only fields of built-in types"),
        ("int8 a 200", "1:8", "outside int8"),
        ("byte a -1", "1:8", "outside byte"),
        ("int8 a 1.5", "1:8", "not an integer"),
        ("float32 a x", "1:11", "not a number"),
        ("bool a yes", "1:8", "not true"),
        ("int32[2] a [1]", "1:12", "1 value for an array of 2"),
        ("int32[<=1] a [1, 2]", "1:14", "2 values for an array of at most 1"),
        ("int32[] a 1", "1:11", "not a list"),
        ("string[] a ['x]", "1:12", "no closing '"),
        ("string<=2 a 'xyz'", "1:13", "longer than 2"),
        ("string a 'it's'", "1:10", "backslash"),
        ("int32 lower=1", "1:7", "not a constant's name"),
        ("int32 A__B=1", "1:7", "not a constant's name"),
        ("Bar A=1", "1:1", "cannot be the type of a constant"),
        ("int32 A=", "1:1", "not an integer"),
    ],
)
def test_reports_where_a_mistake_is(text: str, place: str, says: str) -> None:
    with pytest.raises(DefinitionError) as error:
        parse(text)
    assert str(error.value).startswith(f"Foo.msg:{place}: ")
    assert says in str(error.value)
    assert "\n" not in str(error.value)


def test_refuses_very_long_texts() -> None:
    with pytest.raises(DefinitionError, match="longer than"):
        parse("#" * (1 << 19))
    with pytest.raises(DefinitionError, match="at most 4096 fields"):
        parse("".join(f"int8 a{number}\n" for number in range(5000)))
    with pytest.raises(DefinitionError, match="not an integer"):
        parse(f"int64 A={'9' * 10_000}")


def test_splits_services() -> None:
    service = parse_service("bool data\n---\nbool success\nstring message\n", package="s", name="Set")
    assert service.full_name == "s/srv/Set"
    assert service.request.full_name == "s/srv/Set_Request"
    assert [field.name for field in service.response.fields] == ["success", "message"]
    assert service.response.full_name == "s/srv/Set_Response"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("int32 a\n", "x.srv: the number of '---' lines between request and response is 0, not 1"),
        ("---\n---\n", "x.srv:2:1: the number of '---' lines between request and response is 2, not 1"),
        ("int32 a\n---\nint32 B\n", "x.srv:3:7: 'B' is not a field name"),
    ],
)
def test_reports_where_a_service_is_wrong(text: str, says: str) -> None:
    with pytest.raises(DefinitionError) as error:
        parse_service(text, package="s", name="Set", file="x.srv")
    assert says in str(error.value)
