"""Messages as users type them: the YAML arguments of `rostopic pub` and `rosservice call`.

A single argument that is a mapping gives fields by name; the other fields are zero. Otherwise, each argument
is the value of one field, in order, and none may be missing. A nested message may be a list of all its
fields.

    "{linear: {x: 0.2}}"     "data: hi"     1     "[0.2, 0, 0]" "[0, 0, 1]"     auto "[1, 2]" (a Header, ...)

A time may be `now`, a mapping, `[secs, nsecs]` or a whole number of nanoseconds, a header `auto` (stamped
now), a uint8[] a list, a text or `!!binary`. Beyond genpy: floats may be written as `echo` prints them
(`nan`, `inf`) and as `1e-3`, an empty value means zero, and nanoseconds are exact.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from rostether.bounded_yaml import YamlError, load, load_all
from rostether.errors import SerializationError
from rostether.mechanisms.text import counted
from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message, misfit_error

_FLOAT_TEXT: Final = re.compile(r"[-+]?(nan|inf|infinity|\d+(\.\d*)?e[-+]?\d+|\.\d+e[-+]?\d+)", re.IGNORECASE)
_HEADER: Final = "std_msgs/Header"
# A time in the types of ROS 2.
_ROS2_TIME: Final = "builtin_interfaces/Time"


def parse_values(codec: Codec, arguments: str | Sequence[str], *, now: Callable[[], Time]) -> Message:
    """Return the message that arguments, or one YAML text, describe. Raises SerializationError."""
    return fill_message(codec, load_arguments(arguments), now=now)


def parse_documents(codec: Codec, text: str, *, now: Callable[[], Time]) -> Iterator[Message]:
    """Yield the message of each YAML document (`---` between them), empty ones omitted.

    Raises SerializationError.
    """
    for document in load_documents(text):
        yield fill_message(codec, document, now=now)


def load_arguments(arguments: str | Sequence[str]) -> list[Any]:
    """Return the YAML value of each argument. Raises SerializationError with the position of an error."""
    texts = [arguments] if isinstance(arguments, str) else arguments
    if len(texts) > 1 and texts[0].endswith(":"):
        # The shell has split `data: hello`.
        raise SerializationError(f"put quotes around the message: '{' '.join(texts)}'")
    return [_load_one(text) for text in texts]


def load_documents(text: str) -> Iterator[list[Any]]:
    """Yield the YAML values of each document, empty ones omitted. Raises SerializationError."""
    try:
        for document in load_all(text):
            if document is not None:
                yield document if isinstance(document, list) else [document]
    except YamlError as error:
        raise _syntax_error(text, error) from None


def fill_message(codec: Codec, values: list[Any], *, now: Callable[[], Time]) -> Message:
    """Return the message that loaded arguments describe; each `now` and `auto` reads the clock again.

    Raises SerializationError.
    """
    tree = codec.tree
    value: Any = values
    if len(values) == 1 and isinstance(values[0], dict):
        value = values[0]
    elif values == [None] and not tree.members:
        value = {}
    return codec.conform(_Form(codec.type_name, now).fields(tree, value, ""))


def fill_or_default(codec: Codec, values: list[Any], *, now: Callable[[], Time]) -> Message:
    """Return the message of loaded arguments like `fill_message`; without any, its default values.

    Raises SerializationError.
    """
    return fill_message(codec, [{}] if values in ([], [None]) else values, now=now)


class _Form:
    """Converts YAML values to the input of `Codec.conform`."""

    def __init__(self, type_name: str, now: Callable[[], Time]) -> None:
        self._type_name = type_name
        self._now = now

    def fields(self, tree: Struct, value: Any, path: str) -> dict[str, Any]:
        """Return the fields of a struct given as a mapping, or as a list of all their values."""
        nodes = {member.name: member.node for member in tree.members}
        if isinstance(value, list):
            if len(value) != len(nodes):
                names = f" ({', '.join(nodes)})" if nodes else ""
                wanted = f"{counted(len(nodes), 'value')}{names}, or a mapping"
                raise self._misfit(path, wanted, len(value))
            value = dict(zip(nodes, value, strict=True))
        if not isinstance(value, dict):
            raise self._misfit(path, f"a {tree.name}, as {{field: value}}", value)
        prefix = f"{path}." if path else ""
        return {
            name: self._value(nodes[name], each, f"{prefix}{name}") if name in nodes else each
            for name, each in value.items()
        }

    def _value(self, node: Node, value: Any, path: str) -> Any:
        if isinstance(node, Struct):
            return self._struct(node, value, path)
        if isinstance(node, Array):
            return self._array(node, value, path)
        if isinstance(node, Stamp):
            return self._stamp(node, value, path)
        if isinstance(node, Text):
            return self._text(value, path)
        return self._number(node, value)

    def _struct(self, tree: Struct, value: Any, path: str) -> dict[str, Any]:
        if value is None or value == "":
            return {}
        if value == "auto" and tree.name == _HEADER:
            value = {"stamp": "now"}
        if value == "now" and tree.name == _ROS2_TIME:
            now = self._now()
            return {"sec": now.secs, "nanosec": now.nsecs}
        return self.fields(tree, value, path)

    def _array(self, array: Array, value: Any, path: str) -> Any:
        if value is None:
            return bytes(array.length or 0) if array.is_bytes else []
        if array.is_bytes:
            return value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
        if not isinstance(value, list):
            raise self._misfit(path, f"a list ({array.name})", value)
        return [self._value(array.element, each, f"{path}[{index}]") for index, each in enumerate(value)]

    def _stamp(self, node: Stamp, value: Any, path: str) -> Any:
        if value == "now" and node.name == "time":
            return self._now()
        if isinstance(value, int) and not isinstance(value, bool):
            if node.name == "duration":
                return Duration.from_ns(value)
            return Time(*divmod(value, 10**9))
        if isinstance(value, list) and len(value) == 2:
            return dict(zip(("secs", "nsecs"), value, strict=True))
        if value is None or value == "":
            return {}
        if not isinstance(value, dict):
            now = ", or now" if node.name == "time" else ""
            forms = f"a {node.name}, as {{secs: 1, nsecs: 5}}, [1, 5], whole nanoseconds{now}"
            raise self._misfit(path, forms, value)
        return value

    def _text(self, value: Any, path: str) -> Any:
        if value is None:
            return ""
        if isinstance(value, str | bytes):
            return value
        raise self._misfit(path, "a string (put it in quotes: \"'5'\")", value)

    def _number(self, node: Number, value: Any) -> Any:
        if node.code in "fd" and isinstance(value, str) and _FLOAT_TEXT.fullmatch(value):
            return float(value)
        return value

    def _misfit(self, path: str, wanted: str, got: object) -> SerializationError:
        return misfit_error(self._type_name, path, wanted, got)


def _load_one(text: str) -> Any:
    try:
        return load(text)
    except YamlError as error:
        # YAML contains JSON, except for its escapes of characters beyond U+FFFF, which are two surrogates.
        import json

        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            raise _syntax_error(text, error) from None


def _syntax_error(text: str, error: YamlError) -> SerializationError:
    shown = repr(text if len(text) <= 60 else f"{text[:57]}...")
    return SerializationError(f'{shown} is {error}; write, for example, "{{data: 1}}"')
