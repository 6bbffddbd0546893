"""CDR written the slow and obvious way, from values and the ROS 2 definition: what converters must equal."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from rostether.msgdef.ros2.spec import Ros2Message, Ros2Type
from rostether.rostime import Duration, Time

CODES = {
    "bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H",
    "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip


class CdrWriter:
    """Writes values; `order` is `<` or `>`."""

    def __init__(self, lookup: Callable[[str], Ros2Message], order: str = "<") -> None:
        self._lookup = lookup
        self._order = order
        self._out = bytearray()

    def encoded(self, message: Ros2Message, value: Any) -> bytes:
        self._message(message, value)
        return (b"\0\1\0\0" if self._order == "<" else b"\0\0\0\0") + bytes(self._out)

    def _message(self, message: Ros2Message, value: Any) -> None:
        if not message.fields:
            self._number("uint8", 0)
        for field in message.fields:
            self._value(field.type, _attribute(value, field.name))

    def _value(self, type_: Ros2Type, value: Any) -> None:
        if type_.is_array:
            if type_.length is None:
                self._number("uint32", 0 if value is None else len(value))
            for element in [None] * (type_.length or 0) if value is None else value:
                self._element(type_, element)
        else:
            self._element(type_, value)

    def _element(self, type_: Ros2Type, value: Any) -> None:
        if type_.base == "string":
            raw = (value or "").encode("utf-8", "surrogateescape") + b"\0"
            self._number("uint32", len(raw))
            self._out += raw
        elif type_.base in CODES:
            self._number(type_.base, 0 if value is None else value)
        elif isinstance(value, (Time, Duration)):
            seconds, nanoseconds = value
            self._number("int32", _wrapped(seconds))
            self._number("uint32", nanoseconds % (1 << 32))
        else:
            self._message(self._lookup(type_.base), value)

    def _number(self, name: str, value: Any) -> None:
        code = CODES[name]
        size = struct.calcsize(code)
        self._out += bytes(-len(self._out) % size)
        self._out += struct.pack(self._order + code, value % 256 if name in ("byte", "char") else value)


def _attribute(value: Any, name: str) -> Any:
    """Return a field by its ROS 2 name; None, which is written as zero, where ROS 1 has none."""
    return next((getattr(value, each, None) for each in (name, name.upper()) if hasattr(value, each)), None)


def _wrapped(number: int) -> int:
    return (number + (1 << 31)) % (1 << 32) - (1 << 31)
