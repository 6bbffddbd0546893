from __future__ import annotations

import pytest

from rostether.msgdef.difference import declarations, difference
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.spec import MessageSpec

OURS = "Header header\nfloat32 range\nfloat32 max\nuint8 A=1\n"


def spec(text: str) -> MessageSpec:
    return parse_message(text, package="p", name="N")


@pytest.mark.parametrize(
    ("theirs", "said"),
    [
        (OURS + "# prose", ""),
        (OURS.replace("float32 max\n", ""), "lacks 'float32 max'"),
        (OURS.replace("float32 range", "float64 range"), "has 'float64 range' for 'float32 range'"),
        (OURS.replace("float32 range", "float32[] range"), "has 'float32[] range' for 'float32 range'"),
        (OURS + "int8 more", "has 'int8 more' more"),
        (OURS.replace("uint8 A=1", ""), "lacks the constant 'uint8 A=1'"),
        (OURS.replace("A=1", "A=2"), "has 'uint8 A=2' for 'uint8 A=1'"),
        (OURS + "uint8 B=2", "has the constant 'uint8 B=2' more"),
        (OURS.replace("Header header\n", ""), "lacks 'std_msgs/Header header'"),
        (
            "Header header\nfloat32 max\nfloat32 range\nuint8 A=1",
            "declares the fields in another order: std_msgs/Header header, float32 max, float32 range",
        ),
    ],
)
def test_what_differs_is_reported(theirs: str, said: str) -> None:
    assert difference(spec(OURS), spec(theirs)) == said


def test_the_order_of_constants_counts() -> None:
    assert "constants in another order" in difference(spec("int8 A=1\nint8 B=2"), spec("int8 B=2\nint8 A=1"))


def test_the_written_length_counts() -> None:
    assert difference(spec("int8[5] a"), spec("int8[05] a")) == "has 'int8[05] a' for 'int8[5] a'"


def test_many_differences_are_counted() -> None:
    other = "\n".join(f"int8 x{n}" for n in range(20))
    said = difference(spec(OURS), spec(other))
    assert said.endswith("and 18 more differences")
    assert len(said) < 300


def test_declarations_are_one_line() -> None:
    assert declarations(spec(OURS)) == "std_msgs/Header header, float32 range, float32 max"
    assert declarations(spec("")) == "no fields"
    assert declarations(spec("\n".join(f"int8 x{n}" for n in range(9)))).endswith(
        "int8 x5, and 3 more fields"
    )
