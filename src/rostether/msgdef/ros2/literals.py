"""Reads the values of constants and defaults like rosidl."""

from __future__ import annotations

import re

from rostether.mechanisms.text import counted
from rostether.msgdef.ros2.primitives import INTEGER_RANGES, STRING_TYPES
from rostether.msgdef.ros2.spec import ConstantValue, DefaultValue, Ros2Type
from rostether.names.graph_name import quote

# Longer numbers are out of range. Without this limit, Python's error for thousands of digits would appear.
_MAX_INTEGER_CHARACTERS = 100
_BOOLS = {"true": True, "1": True, "false": False, "0": False}


def read_default(field_type: Ros2Type, text: str) -> DefaultValue:
    """Read a field's default: one literal, or `[a, b, ...]` for an array. Raises ValueError."""
    if not field_type.is_array:
        return read_literal(field_type.base, text, string_bound=field_type.string_bound)
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError(f"{quote(text)} is not a list in brackets, such as [1, 2, 3]")
    inner = text[1:-1].strip()
    if field_type.base in STRING_TYPES:
        parts = _split_strings(inner)
    else:
        parts = [part.strip() for part in inner.split(",")] if inner else []
    if field_type.length is not None and len(parts) != field_type.length:
        raise ValueError(f"{counted(len(parts), 'value')} for an array of {field_type.length}")
    if field_type.bound is not None and len(parts) > field_type.bound:
        raise ValueError(f"{counted(len(parts), 'value')} for an array of at most {field_type.bound}")
    return tuple(read_literal(field_type.base, part, string_bound=field_type.string_bound) for part in parts)


def read_literal(base: str, text: str, *, string_bound: int | None = None) -> ConstantValue:
    """Read one value of a primitive type. Raises ValueError."""
    if base in STRING_TYPES:
        return _read_string(text, string_bound)
    if base == "bool":
        value = _BOOLS.get(text.lower())
        if value is None:
            raise ValueError(f"{quote(text)} is not true, false, 1 or 0")
        return value
    if base in ("float32", "float64"):
        try:
            return float(text)
        except ValueError:
            raise ValueError(f"{quote(text)} is not a number") from None
    return _read_integer(base, text)


def _read_integer(base: str, text: str) -> int:
    try:
        if len(text) > _MAX_INTEGER_CHARACTERS:
            raise ValueError(text)
        try:
            value = int(text)
        except ValueError:
            value = int(text, 0)
    except ValueError:
        raise ValueError(f"{quote(text)} is not an integer") from None
    low, high = INTEGER_RANGES[base]
    if not low <= value <= high:
        raise ValueError(f"{quote(text)} is outside {base} ({low} to {high})")
    return value


def _read_string(text: str, bound: int | None) -> str:
    for mark in ('"', "'"):
        if text.startswith(mark) and text.endswith(mark):
            text = text[1:-1]
            if re.search(rf"(?<!\\){mark}", text):
                raise ValueError(f"{quote(text)} has a {mark} inside that needs a backslash")
            text = text.replace("\\" + mark, mark)
            break
    if bound is not None and len(text) > bound:
        raise ValueError(f"{quote(text)} is longer than {bound} characters")
    return text


def _split_strings(text: str) -> list[str]:
    """Split at the commas outside quotes."""
    parts: list[str] = []
    start = 0
    mark = ""
    for index, character in enumerate(text):
        if mark:
            if character == mark and text[index - 1] != "\\":
                mark = ""
        elif character in "\"'" and not text[start:index].strip():
            mark = character
        elif character == ",":
            parts.append(text[start:index].strip())
            start = index + 1
    if mark:
        raise ValueError(f"{quote(text[start:].strip())} has no closing {mark}")
    # rosidl accepts a comma after the last string.
    if last := text[start:].strip():
        parts.append(last)
    return parts
