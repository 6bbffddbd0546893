"""The values of ROS 2 parameters: each has one type, and all items of a list have the same type."""

from __future__ import annotations

import json
from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from msgspec import Struct

from rostether.errors import SerializationError
from rostether.graph.ports import ParamValue
from rostether.mechanisms.text import escape_line
from rostether.serde.values import Message

_INT64 = range(-(2**63), 2**63)

# The length of a value in an error, so that the error is one readable line.
_MAX_SHOWN_CHARACTERS = 60


class ParameterType(IntEnum):
    """The types with the values of rcl_interfaces/ParameterType."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9

    @property
    def field(self) -> str:
        """The field of an rcl_interfaces/ParameterValue with a value of this type."""
        return f"{self.name.lower()}_value"


class TypedValue(Struct, frozen=True):
    """A parameter's value and its type; even an empty list has a type."""

    type: ParameterType
    value: ParamValue

    @property
    def may_have_other_type(self) -> bool:
        """Whether the value may be meant as another type: a whole number, or an empty list."""
        is_whole = self.type in (ParameterType.INTEGER, ParameterType.INTEGER_ARRAY)
        return is_whole or (self.type is ParameterType.STRING_ARRAY and not self.value)

    def as_type(self, wanted: int | None) -> TypedValue:
        """Return the value as the wanted type if it may be meant as that type, else unchanged."""
        value: Any = self.value
        if self.type is ParameterType.INTEGER and wanted == ParameterType.DOUBLE:
            return TypedValue(ParameterType.DOUBLE, float(value))
        if not self.may_have_other_type or not isinstance(value, list):
            return self
        if wanted == ParameterType.DOUBLE_ARRAY:
            return TypedValue(ParameterType.DOUBLE_ARRAY, [float(each) for each in value])
        if wanted == ParameterType.BYTE_ARRAY and all(0 <= each <= 255 for each in value):
            return TypedValue(ParameterType.BYTE_ARRAY, bytes(value))
        if not value and wanted in (ParameterType.BOOL_ARRAY, ParameterType.INTEGER_ARRAY):
            return TypedValue(ParameterType(wanted), [])
        return self

    def to_fields(self) -> dict[str, Any]:
        """Return the fields of an rcl_interfaces/ParameterValue."""
        fields: dict[str, Any] = {"type": int(self.type)}
        if isinstance(self.value, bytes):
            # In ROS 1, `byte` is a signed number.
            fields[self.type.field] = [byte - 256 if byte > 127 else byte for byte in self.value]
        elif self.type is not ParameterType.NOT_SET:
            fields[self.type.field] = self.value
        return fields


NOT_SET = TypedValue(ParameterType.NOT_SET, None)


def typed_value(name: str, value: ParamValue) -> TypedValue:
    """Return a value with its type: None becomes NOT_SET, and integers in a list with floats become floats.

    Raises SerializationError naming the parameter if ROS 2 does not support the value.
    """
    if value is None:
        return NOT_SET
    if isinstance(value, bytes):
        return TypedValue(ParameterType.BYTE_ARRAY, value)
    if isinstance(value, list):
        return _typed_list(name, value)
    scalar = _scalar_type(value)
    if scalar is None:
        raise _refusal(name, value)
    return TypedValue(scalar, value)


def value_of_message(message: Message) -> TypedValue:
    """Read an rcl_interfaces/ParameterValue. Raises SerializationError for a type that does not exist."""
    try:
        kind = ParameterType(message.type)
    except ValueError:
        raise SerializationError(
            f"a parameter has type {message.type}, which rcl_interfaces/ParameterType does not define"
        ) from None
    if kind is ParameterType.NOT_SET:
        return NOT_SET
    value = getattr(message, kind.field)
    if kind is ParameterType.BYTE_ARRAY:
        value = bytes(byte & 0xFF for byte in value)
    return TypedValue(kind, value)


def show_value(value: object) -> str:
    """Return a value for an error: one short line in JSON, as users write it."""
    return escape_line(
        json.dumps(value, ensure_ascii=False, skipkeys=True, default=str), _MAX_SHOWN_CHARACTERS
    )


def flatten(path: str, value: ParamValue) -> dict[str, TypedValue]:
    """Return the parameters of a value or mapping, by their names with dots.

    Raises SerializationError for values that ROS 2 does not support.
    """
    if not isinstance(value, Mapping):
        return {path: typed_value(path, value)}
    flat: dict[str, TypedValue] = {}
    for key, item in value.items():
        below = ".".join(part for part in str(key).split("/") if part)
        flat |= flatten(f"{path}.{below}" if path else below, item)
    return flat


def _typed_list(name: str, value: list[ParamValue]) -> TypedValue:
    types = {_scalar_type(item) for item in value}
    if not types:
        return TypedValue(ParameterType.STRING_ARRAY, [])
    if types == {ParameterType.INTEGER, ParameterType.DOUBLE}:
        return TypedValue(
            ParameterType.DOUBLE_ARRAY, [float(item) for item in value if isinstance(item, int | float)]
        )
    kind = types.pop()
    if kind is None or types:
        raise _refusal(name, value)
    return TypedValue(ParameterType[f"{kind.name}_ARRAY"], list(value))


def _scalar_type(value: ParamValue) -> ParameterType | None:
    if isinstance(value, bool):
        return ParameterType.BOOL
    if isinstance(value, int):
        return ParameterType.INTEGER if value in _INT64 else None
    if isinstance(value, float):
        return ParameterType.DOUBLE
    return ParameterType.STRING if isinstance(value, str) else None


def _refusal(name: str, value: ParamValue) -> SerializationError:
    return SerializationError(
        f"parameter {name} cannot be {show_value(value)} in ROS 2; use a bool, 64-bit integer, float, "
        "string, bytes, or a list of one type of them"
    )
