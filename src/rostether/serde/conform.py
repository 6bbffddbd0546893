"""Converts a value to the form of its type, or reports which field does not fit and what it needs.

The slow part of encoding: it accepts mappings, lists, tuples and incomplete messages, and is the only source
of error texts for values.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rostether.errors import SerializationError
from rostether.mechanisms.text import counted
from rostether.rostime import Duration, Time
from rostether.serde.encoder_source import ENCODE_ERRORS, FLAGS, to_bytes
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message, MessageClasses, misfit_error, unknown_field


class Conformer:
    """Conforms values to one message type."""

    def __init__(self, tree: Struct, classes: MessageClasses, now: Callable[[], Time] | None = None) -> None:
        self._now = now
        self._tree = tree
        self._classes = classes

    def message(self, value: object) -> Message:
        """Return a complete message. Missing fields of a mapping are zero. Raises SerializationError."""
        return self._struct(self._tree, value, "")

    def _struct(self, tree: Struct, value: object, path: str) -> Message:
        if isinstance(value, Message):
            return self._from_message(tree, value, path)
        if not isinstance(value, Mapping):
            raise self._misfit(path, f"a {tree.name} or a mapping of its fields", value)
        message = self._classes.of(tree)()
        rest = dict(value)
        for member in tree.members:
            if member.name in rest:
                field = f"{path}.{member.name}" if path else member.name
                setattr(message, member.name, self._node(member.node, rest.pop(member.name), field))
        if rest:
            known = [member.name for member in tree.members]
            raise unknown_field(f"{self._tree.name}.{path}" if path else tree.name, next(iter(rest)), known)
        return message

    def _from_message(self, tree: Struct, value: Message, path: str) -> Message:
        if value._type != tree.name:
            raise self._misfit(path, f"a {tree.name}", value._type)
        message = self._classes.of(tree)()
        for member in tree.members:
            field = f"{path}.{member.name}" if path else member.name
            setattr(message, member.name, self._node(member.node, getattr(value, member.name, None), field))
        return message

    def _node(self, node: Node, value: object, path: str) -> Any:
        if isinstance(node, Number):
            return self._number(node, value, path)
        if isinstance(node, Text):
            return self._text(value, path)
        if isinstance(node, Stamp):
            return self._stamp(node, value, path)
        if isinstance(node, Array):
            return self._array(node, value, path)
        return self._struct(node, value, path)

    def _number(self, node: Number, value: Any, path: str) -> bool | int | float:
        try:
            if node.code == "?":
                return bool(FLAGS[value])
            struct.pack(f"<{node.code}", value)
        except ENCODE_ERRORS:
            raise self._misfit(path, _number_text(node), value) from None
        return float(value) if node.code in "fd" else int(value)

    def _text(self, value: object, path: str) -> str:
        if isinstance(value, bytes):
            return value.decode("utf-8", "surrogateescape")
        if isinstance(value, str):
            try:
                value.encode("utf-8", "surrogateescape")
            except UnicodeEncodeError:
                raise self._misfit(path, "a string that UTF-8 can encode", value) from None
            return value
        raise self._misfit(path, "a string", value)

    def _stamp(self, node: Stamp, value: Any, path: str) -> Time | Duration:
        if isinstance(value, Mapping):
            unknown = [key for key in value if key not in ("secs", "nsecs")]
            if unknown:
                raise unknown_field(f"{self._tree.name}.{path}", unknown[0], ["secs", "nsecs"])
            secs, nsecs = value.get("secs", 0), value.get("nsecs", 0)
        elif self._now is not None and node.name == "time" and isinstance(value, str) and value == "now":
            return self._now()
        elif self._now is not None and _is_seconds(value, is_signed=node.name != "time"):
            since = Time.from_s(value) if node.name == "time" else Duration.from_s(value)
            secs, nsecs = since.secs, since.nsecs
        else:
            secs, nsecs = getattr(value, "secs", None), getattr(value, "nsecs", None)
        try:
            struct.pack(f"<{node.code}", secs, nsecs)
        except ENCODE_ERRORS:
            kind = "uint32" if node.name == "time" else "int32"
            raise self._misfit(path, f"a {node.name} (secs and nsecs, each {kind})", value) from None
        return Time(secs, nsecs) if node.name == "time" else Duration(secs, nsecs)

    def _array(self, node: Array, value: Any, path: str) -> bytes | list[Any]:
        items = value
        if node.is_bytes:
            items = self._bytes(node, value, path)
        elif not _is_list(value):
            raise self._misfit(path, f"a list ({node.name})", value)
        if node.length is not None and len(items) != node.length:
            raise self._misfit(path, f"{counted(node.length, 'element')} ({node.name})", len(items))
        if node.max_count is not None and len(items) > node.max_count:
            raise self._misfit(path, f"at most {node.max_count} elements", len(items))
        if isinstance(items, bytes):
            return items
        return [self._node(node.element, item, f"{path}[{index}]") for index, item in enumerate(items)]

    def _bytes(self, node: Array, value: object, path: str) -> bytes:
        try:
            return to_bytes(value)
        except ENCODE_ERRORS:
            if isinstance(value, list | tuple):
                # Raises the error of the first element that does not fit.
                for index, item in enumerate(value):
                    self._node(node.element, item, f"{path}[{index}]")
            raise self._misfit(
                path, f"bytes or a list of integers from 0 to 255 ({node.name})", value
            ) from None

    def _misfit(self, path: str, wanted: str, got: object) -> SerializationError:
        return misfit_error(self._tree.name, path, wanted, got)


def _is_seconds(value: Any, *, is_signed: bool) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value) and (is_signed or value >= 0)


def _is_list(value: object) -> bool:
    if isinstance(value, str | bytes | bytearray | Mapping):
        return False
    return isinstance(value, Sequence) or hasattr(value, "__array__")


def _number_text(node: Number) -> str:
    article = "an" if node.name[0] == "i" else "a"
    if node.code == "?":
        return "a bool (true or false)"
    if node.code in "fd":
        return f"{article} {node.name}"
    bits = 8 * node.fixed_size_bytes
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if node.code.islower() else (0, (1 << bits) - 1)
    return f"{article} {node.name} ({low} to {high})"
