"""ROS messages in rosbridge's JSON, in both directions.

As in rosbridge, uint8[] and char[] are base64. Times and durations are `{"secs": ..., "nsecs": ...}`, on a
ROS 2 graph `{"sec": ..., "nanosec": ...}`. NaN and infinities, which JSON does not support, become null.
Bytes of a string that are not UTF-8 become U+FFFD.

Input is what web pages send: with the field names of ROS 1 or ROS 2, missing fields, bytes as base64 or a
list, and null as the NaN of a float. An error names the field that does not fit.
"""

from __future__ import annotations

import json
import math
from binascii import a2b_base64
from collections.abc import Mapping
from typing import Any, Final

from rostether.errors import SerializationError
from rostether.gateways.client_json import show
from rostether.gateways.rosbridge.form_source import (
    CompiledForms,
    Leaves,
    NotFiniteError,
    Style,
    compile_text,
    compile_values,
)
from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.plain_form import base64_text
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message

_HEADER: Final = "std_msgs/Header"

# The type of times in ROS 2's own definitions.
_ROS2_TIME: Final = "builtin_interfaces/Time"

# The limit of messages and strings in the arrays of one message, enough for a path of many hours: larger
# messages would delay all clients.
MAX_ELEMENTS: Final = 1 << 18

_FLOATS: Final = frozenset({float, int})
_INTEGERS: Final = frozenset({int})
_SECONDS: Final = ("secs", "sec")
_NANOSECONDS: Final = ("nsecs", "nanosec")
_ROS2_HALVES: Final = {"secs": "sec", "nsecs": "nanosec"}

_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


class JsonForm:
    """Converts messages of all types to JSON values and back; `style` chooses the field names."""

    def __init__(self, style: Style = Style.ROS1) -> None:
        leaves = Leaves(style, base64_text)
        self._readers = CompiledForms(compile_values, leaves)
        self._writers = CompiledForms(compile_text, leaves)

    def text(self, codec: Codec, payload: bytes) -> str:
        """Return a payload as JSON text, the same as from `write_json` but faster.

        Raises SerializationError.
        """
        message = codec.decode(payload)
        try:
            return self._writers.of(codec)(message)
        except NotFiniteError:
            return write_json(self.to_json(codec, payload))

    def to_json(self, codec: Codec, payload: bytes) -> dict[str, Any]:
        """Return a payload as values for `write_json`. Raises SerializationError."""
        return self._readers.of(codec)(codec.decode(payload))

    def from_json(self, codec: Codec, value: object, now: Time) -> bytes:
        """Return the payload of a JSON value.

        Missing fields are zero. A missing stamp of a header, and a time "now", become `now`. Raises
        SerializationError with the name of the field that does not fit.
        """
        try:
            message = _Reader(codec, now).struct(codec.tree, value)
        except _MisfitError as misfit:
            raise SerializationError(misfit.message(codec.type_name)) from None
        # Numbers that do not fit their type are reported here.
        return codec.encode(message)


class JsonText(str):
    """A JSON text, which `write_json` must not encode again."""

    __slots__ = ()


def write_json(value: object) -> str:
    """Return values of `to_json`, and dicts and lists of them, as JSON; NaN and infinities become null."""
    try:
        return _encode(value)
    except ValueError:
        return _encode(_finite(value))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


class _MisfitError(Exception):
    """A value does not fit; the path to it is completed while the exception propagates."""

    def __init__(self, wanted: str, got: object, path: str = "") -> None:
        super().__init__(wanted)
        self.path = path
        self._wanted = wanted
        self._got = got

    def within(self, step: str) -> None:
        """Add a step to the front of the path."""
        self.path = step + self.path if not self.path or self.path[0] == "[" else f"{step}.{self.path}"

    def message(self, type_name: str) -> str:
        where = f" for field {self.path}" if self.path else ""
        return f"{type_name} needs {self._wanted}{where}, got {show(self._got)}"


class _UnknownFieldError(_MisfitError):
    """An object has a field that its type does not have; `known` lists the type's fields for the error."""

    def __init__(self, name: str, known: str) -> None:
        super().__init__(known, name, path=show(name)[1:-1])
        self._known = known

    def message(self, type_name: str) -> str:
        return f"{type_name} has no field {self.path}; it has {self._known}"


class _Reader:
    def __init__(self, codec: Codec, now: Time) -> None:
        self._codec = codec
        self._now = now
        self._elements_left = MAX_ELEMENTS

    def struct(self, tree: Struct, value: object) -> Message:
        """Return a message whose missing fields are zero. Raises _MisfitError."""
        if tree.name == _ROS2_TIME:
            value = self._ros2_time(value)
        if not isinstance(value, Mapping):
            raise _MisfitError(f"an object ({tree.name})", value)
        message_class = self._codec.class_of(tree)
        message = message_class.__new__(message_class)
        left = len(value)
        for member, (name, zero) in zip(tree.members, message_class._zeros, strict=True):
            if name in value:
                left -= 1
                try:
                    found = self._node(member.node, value[name])
                except _MisfitError as misfit:
                    misfit.within(name)
                    raise
            elif name == "header" and isinstance(member.node, Struct) and member.node.name == _HEADER:
                found = self.struct(member.node, {})
            elif name == "stamp" and tree.name == _HEADER:
                found = self._node(member.node, "now")
            else:
                found = zero() if callable(zero) else zero
            setattr(message, name, found)
        if left:
            _refuse_unknown(tree, value)
        return message

    def _node(self, node: Node, value: Any) -> Any:
        if isinstance(node, Number):
            return _number(node, value)
        if isinstance(node, Text):
            if not isinstance(value, str):
                raise _MisfitError("a string", value)
            return value if value.isascii() else _valid_text(value)
        if isinstance(node, Struct):
            return self.struct(node, value)
        if isinstance(node, Stamp):
            return _stamp(node, value, self._now)
        return self._array(node, value)

    def _array(self, array: Array, value: Any) -> bytes | list[Any]:
        element = array.element
        if array.is_bytes and isinstance(value, str):
            try:
                return _decoded(value)
            except ValueError:
                raise _MisfitError(f"base64 or a list of integers ({array.name})", value) from None
        if not isinstance(value, list):
            raise _MisfitError(f"a list ({array.name})", value)
        if isinstance(element, Number) and element.code != "?":
            # Most data of large messages; packing checks whether each number fits.
            kinds = set(map(type, value))
            if kinds <= (_FLOATS if element.code in "fd" else _INTEGERS):
                return _packed(value) if array.is_bytes else value
        self._elements_left -= len(value)
        if self._elements_left < 0:
            raise _MisfitError(f"at most {MAX_ELEMENTS} elements in total", value)
        items = []
        for index, each in enumerate(value):
            try:
                items.append(self._node(element, each))
            except _MisfitError as misfit:
                misfit.within(f"[{index}]")
                raise
        return items

    def _ros2_time(self, value: object) -> object:
        if value == "now":
            return {"sec": self._now.secs, "nanosec": self._now.nsecs}
        if isinstance(value, Mapping):
            return {_ROS2_HALVES.get(name, name): each for name, each in value.items()}
        return value


def _decoded(text: str) -> bytes:
    """Return decoded base64.

    Raises ValueError for invalid base64 and for data URLs, whose prefix would decode to wrong data.
    """
    try:
        return a2b_base64(text, strict_mode=True)
    except ValueError:
        # Some clients insert line breaks.
        return a2b_base64("".join(text.split()), strict_mode=True)


def _packed(values: list[int]) -> bytes | list[int]:
    try:
        return bytes(values)
    except ValueError:
        return values


def _refuse_unknown(tree: Struct, value: Mapping[Any, Any]) -> None:
    known = [member.name for member in tree.members]
    for name in value:
        # Pages written for ROS 1 send `seq` in headers, which ROS 2 does not have.
        if name not in known and not (name == "seq" and tree.name == _HEADER):
            raise _UnknownFieldError(str(name), ", ".join(known) or "no fields")


def _number(node: Number, value: Any) -> bool | int | float:
    kind = type(value)
    if node.code == "?":
        if kind is bool:
            return bool(value)
    elif node.code in "fd":
        if kind in _FLOATS:
            return value  # type: ignore[no-any-return]
        if value is None:
            return math.nan
    elif kind is int or (kind is float and value.is_integer()):
        return int(value)
    raise _MisfitError(f"{'an' if node.name[0] == 'i' else 'a'} {node.name}", value)


def _stamp(node: Stamp, value: Any, now: Time) -> Time | Duration:
    kind = Time if node.name == "time" else Duration
    if value == "now" and kind is Time:
        return now
    if not isinstance(value, Mapping):
        raise _MisfitError(f"a {node.name}, an object of secs and nsecs", value)
    left = set(value)
    parts = []
    for names in (_SECONDS, _NANOSECONDS):
        name = next((each for each in names if each in value), None)
        part = 0 if name is None else value[name]
        left.discard(name)
        if type(part) is float and part.is_integer():
            part = int(part)
        if type(part) is not int:
            raise _MisfitError("an integer", part, path=str(name))
        parts.append(part)
    if left:
        raise _UnknownFieldError(str(left.pop()), "secs and nsecs, or sec and nanosec")
    return kind(*parts)


def _valid_text(text: str) -> str:
    """Return a string with surrogate pairs joined and lone surrogates replaced, because UTF-8 has none."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    return text
