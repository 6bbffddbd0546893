"""Values of parameters: their types, unsupported values, and their form in messages."""

from __future__ import annotations

import pytest

from rostether.errors import SerializationError
from rostether.graph.ports import ParamValue
from rostether.ros2.parameters.typed_value import (
    NOT_SET,
    ParameterType,
    TypedValue,
    flatten,
    typed_value,
    value_of_message,
)
from rostether.ros2.rcl_interfaces import rcl_interfaces

TYPED: list[tuple[ParamValue, ParameterType]] = [
    (True, ParameterType.BOOL),
    (-(2**63), ParameterType.INTEGER),
    (2**63 - 1, ParameterType.INTEGER),
    (0.1, ParameterType.DOUBLE),
    ("ä", ParameterType.STRING),
    (bytes(range(256)), ParameterType.BYTE_ARRAY),
    ([True, False], ParameterType.BOOL_ARRAY),
    ([1, -2], ParameterType.INTEGER_ARRAY),
    ([1.5], ParameterType.DOUBLE_ARRAY),
    (["a", ""], ParameterType.STRING_ARRAY),
    ([], ParameterType.STRING_ARRAY),
    (None, ParameterType.NOT_SET),
]


@pytest.mark.parametrize(("value", "kind"), TYPED)
def test_a_value_has_a_type_and_is_the_same_after_a_message(value: ParamValue, kind: ParameterType) -> None:
    typed = typed_value("a", value)
    assert typed == TypedValue(kind, value)
    codec = rcl_interfaces().codec("ParameterValue")
    received = value_of_message(codec.decode(codec.encode(typed.to_fields())))
    assert received == typed
    assert type(received.value) is type(value)


def test_an_empty_list_keeps_its_type() -> None:
    codec = rcl_interfaces().codec("ParameterValue")
    for kind in list(ParameterType)[6:]:
        empty = TypedValue(kind, [])
        assert value_of_message(codec.decode(codec.encode(empty.to_fields()))) == empty


def test_integers_among_floats_become_floats() -> None:
    typed = typed_value("a", [1, 2.5])
    assert typed.type is ParameterType.DOUBLE_ARRAY
    assert typed.value == [1.0, 2.5]
    assert [type(item) for item in [1.0, 2.5]] == [float, float]


@pytest.mark.parametrize(
    "value", [2**63, [1, "a"], [True, 1], [[1]], [None], [{}], [2**63], [b""], ["x" * 1000, 1]]
)
def test_values_that_ros2_does_not_support_are_refused(value: ParamValue) -> None:
    with pytest.raises(SerializationError, match="parameter a cannot be") as caught:
        typed_value("a", value)
    assert len(str(caught.value)) < 250


def test_refused_values_are_shown_as_users_write_them() -> None:
    with pytest.raises(SerializationError, match=r'cannot be \[null, true, "ä"\] in ROS 2'):
        typed_value("a", [None, True, "ä"])


def test_a_mapping_is_flattened() -> None:
    assert flatten("arm", {"p": 1, "d": {"i": "x"}, "c/e": True, "none": {}}) == {
        "arm.p": typed_value("", 1),
        "arm.d.i": typed_value("", "x"),
        "arm.c.e": typed_value("", True),
    }
    assert flatten("", {"a": 1}) == {"a": typed_value("", 1)}
    assert flatten("a", 1) == {"a": typed_value("", 1)}
    assert flatten("a", None) == {"a": NOT_SET}


def test_an_unknown_type_is_refused() -> None:
    codec = rcl_interfaces().codec("ParameterValue")
    with pytest.raises(SerializationError, match="type 10"):
        value_of_message(codec.decode(codec.encode({"type": 10})))
