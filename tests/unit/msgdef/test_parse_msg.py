from __future__ import annotations

import math

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.parse_msg import (
    MAX_ARRAY_LENGTH,
    MAX_FIELDS,
    MAX_TEXT_CHARACTERS,
    parse_message,
)
from rostether.msgdef.primitives import CONSTANT_TYPES, INTEGER_RANGES, PRIMITIVE_TYPES
from rostether.msgdef.spec import ConstantValue, Field, FieldType, MessageSpec


def parse(text: str) -> MessageSpec:
    return parse_message(text, package="my_msgs", name="Foo", file="Foo.msg")


def one_constant(text: str) -> tuple[ConstantValue, str]:
    (constant,) = parse(text).constants
    return constant.value, constant.text


def test_a_definition_is_read_in_order() -> None:
    text = (
        "# wheels\nint32 LEFT=1 # one\nHeader header\nfloat32 speed # m/s\nint32 RIGHT=2\nWheel[4] wheels\n"
    )
    spec = parse(text)
    assert spec.full_name == "my_msgs/Foo"
    assert spec.text == text
    assert [(str(field.type), field.name) for field in spec.fields] == [
        ("std_msgs/Header", "header"),
        ("float32", "speed"),
        ("my_msgs/Wheel[4]", "wheels"),
    ]
    assert [(c.type, c.name, c.value, c.text) for c in spec.constants] == [
        ("int32", "LEFT", 1, "1"),
        ("int32", "RIGHT", 2, "2"),
    ]


@pytest.mark.parametrize("text", ["", "\n\n", "# only words\n", "   \n\t\n#"])
def test_a_definition_may_be_empty(text: str) -> None:
    spec = parse(text)
    assert (spec.fields, spec.constants, spec.text) == ((), (), text)


@pytest.mark.parametrize("name", sorted(PRIMITIVE_TYPES))
def test_every_primitive_is_a_field_and_an_array(name: str) -> None:
    fields = parse(f"{name} a\n{name}[] b\n{name}[3] c").fields
    assert fields == (
        Field(FieldType(name), "a"),
        Field(FieldType(name, is_array=True), "b"),
        Field(FieldType(name, is_array=True, length=3), "c"),
    )


@pytest.mark.parametrize(
    ("written", "base"),
    [
        ("Header", "std_msgs/Header"),
        ("std_msgs/Header", "std_msgs/Header"),
        ("my_msgs/Header", "my_msgs/Header"),
        ("Header[]", "my_msgs/Header"),
        ("Bar", "my_msgs/Bar"),
        ("other/Bar", "other/Bar"),
        ("string", "string"),
    ],
)
def test_types_without_a_package_are_of_the_same_package(written: str, base: str) -> None:
    (field,) = parse(f"{written} x").fields
    assert field.type.base == base


def test_the_length_stays_as_written_but_is_a_number() -> None:
    (field,) = parse("int8[007] x").fields
    assert field.type == FieldType("int8", is_array=True, length=7)
    assert str(field.type) == "int8[007]"


@pytest.mark.parametrize("type_name", sorted(INTEGER_RANGES))
def test_integer_constants_are_within_their_bounds(type_name: str) -> None:
    low, high = INTEGER_RANGES[type_name]
    assert one_constant(f"{type_name} X={low}") == (low, str(low))
    assert one_constant(f"{type_name} X={high}") == (high, str(high))
    for outside in (low - 1, high + 1):
        with pytest.raises(DefinitionError, match=f"outside {type_name}"):
            parse(f"{type_name} X={outside}")


@pytest.mark.parametrize(
    ("text", "value", "kept"),
    [
        ("int32 X=05", 5, "05"),
        ("int32 X =  +7  # seven", 7, "+7"),
        ("float32 X=1e-3", 1e-3, "1e-3"),
        ("float64 X = -.5 #", -0.5, "-.5"),
        ("float32 X=inf", math.inf, "inf"),
        ("bool X=True", True, "True"),
        ("bool X=0", False, "0"),
        ("bool X=05.0", True, "05.0"),
        ("string X=", "", ""),
        ("string X=   ", "", ""),
        ("string X=  padded  text  ", "padded  text", "padded  text"),
        ('string X="quoted" # kept', '"quoted" # kept', '"quoted" # kept'),
        ("string X=#", "#", "#"),
        ("string X=a=b", "a=b", "a=b"),
        ("string X=text\r", "text", "text"),
        ("  string X=indented", "indented", "indented"),
        ("string\tX\t=\ttabs", "tabs", "tabs"),
        ("uint8 _X=1", 1, "1"),
    ],
)
def test_constants_of_every_type(text: str, value: ConstantValue, kept: str) -> None:
    assert one_constant(text) == (value, kept)
    assert parse(text).constants[0].name.strip("_") == "X"


def test_constants_have_no_times_messages_or_arrays() -> None:
    assert PRIMITIVE_TYPES - {"time", "duration"} == CONSTANT_TYPES
    for type_name in ("time", "duration", "Header", "int32[]"):
        with pytest.raises(DefinitionError, match="type of a constant"):
            parse(f"{type_name} X=1")


@pytest.mark.parametrize(
    ("text", "line", "column", "reason"),
    [
        ("int32 a\nint32 b c", 2, 1, "'type name'"),
        ("int32", 1, 1, "'type name'"),
        ("  int32  1a", 1, 10, "field name"),
        ("int32 _a", 1, 7, "field name"),
        ("int-32 a", 1, 1, "not a type"),
        ("int32[ a", 1, 1, "not a type"),
        ("int32[-1] a", 1, 1, "not a type"),
        ("int32[][] a", 1, 1, "not a type"),
        ("a/b/c d", 1, 1, "not a type"),
        ("string<=5 a", 1, 1, "'string<=5 a' has a bound; only definitions of ROS 2 have bounds"),
        ("int32 a\n\n int32 a", 3, 8, "declared twice"),
        ("int32 X=0x10", 1, 9, "not a decimal integer"),
        ("int32 X=", 1, 1, "not a decimal integer"),
        ("int32 X=1=2", 1, 9, "not a decimal integer"),
        ("float32 X = abc", 1, 13, "not a number"),
        ("bool X=true", 1, 8, "True, False, 1 or 0"),
        ("int32 A B=1", 1, 9, "constant's name"),
        ("int32 =1", 1, 1, "constant's name"),
        ("=1", 1, 1, "type of a constant"),
        (f"uint8[{MAX_ARRAY_LENGTH + 1}] a", 1, 1, "at most"),
        (f"uint8[{'9' * 5000}] a", 1, 1, "at most"),
        (f"int32 X={'9' * 5000}", 1, 9, "not a decimal integer"),
        (f"bool X={'[' * 5000}", 1, 8, "True, False, 1 or 0"),
    ],
)
def test_a_mistake_is_one_line_with_its_position(text: str, line: int, column: int, reason: str) -> None:
    with pytest.raises(DefinitionError, match=reason) as raised:
        parse(text)
    error = raised.value
    assert (error.file, error.line, error.column) == ("Foo.msg", line, column)
    assert str(error).startswith(f"Foo.msg:{line}:{column}: ")
    assert "\n" not in str(error)
    assert len(str(error)) < 300


def test_without_a_file_the_type_is_named() -> None:
    with pytest.raises(DefinitionError, match=r"^my_msgs/Foo:1:1: "):
        parse_message("oops", package="my_msgs", name="Foo")


def test_text_and_fields_are_bounded() -> None:
    with pytest.raises(DefinitionError, match="longer"):
        parse("#" * (MAX_TEXT_CHARACTERS + 1))
    declarations = [f"int8 a{number}" for number in range(MAX_FIELDS)]
    assert len(parse("\n".join(declarations)).fields) == MAX_FIELDS
    with pytest.raises(DefinitionError, match=rf"Foo\.msg:{MAX_FIELDS + 1}:1: a message can have at most"):
        parse("\n".join([*declarations, "int8 last"]))


def test_lines_may_start_in_the_middle_of_a_file() -> None:
    with pytest.raises(DefinitionError, match=":12:1:"):
        parse_message("int8 a\noops\n", package="p", name="N", first_line=11)
