"""Writes the Python source that encodes a type: fields of constant size fused into one packing.

For std_msgs/Header the result is:

    def encode(m):
        v0 = m.stamp
        v1 = m.frame_id.encode('utf-8', 'surrogateescape')
        return b''.join((pack_0(m.seq, v0.secs, v0.nsecs, len(v1)), v1))

`struct` checks the range of every number. The source checks what `struct` would accept (a string as a bool,
an array of the wrong length). After an error, `conform` finds the reason.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, Final

from rostether.serde.generated_source import attribute, indented
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message, MessageClasses

Encode = Callable[[Message], bytes]

# The limit of fields of inline structs in one function; further structs get their own functions. Otherwise,
# the source would grow exponentially if each type contains the next one twice.
_MAX_FIELDS: Final = 512

# The errors of encoding a value that does not fit.
ENCODE_ERRORS: Final = (struct.error, AttributeError, KeyError, OverflowError, TypeError, ValueError)

# The accepted values of a bool: anything equal to 0 or 1, as in genpy.
FLAGS: Final = {False: 0, True: 1}


def compile_encoder(tree: Struct, classes: MessageClasses) -> Encode:
    """Return the function that encodes a message; it raises one of ENCODE_ERRORS. Raises DefinitionError."""
    classes.of(tree)
    source = _EncoderSource()
    source.function("encode", tree)
    exec(compile("\n".join(source.functions), f"<encoder of {tree.name}>", "exec"), source.names)  # noqa: S102
    return source.names["encode"]  # type: ignore[no-any-return]


class _EncoderSource:
    """Collects the functions of nested types, and the names that the source refers to."""

    def __init__(self) -> None:
        self.functions: list[str] = []
        self.names: dict[str, Any] = {
            "pack": struct.pack,
            "flags": FLAGS,
            "pack_texts": _pack_texts,
            "to_bytes": to_bytes,
        }
        self._bound: dict[tuple[str, str], str] = {}
        self._fields: dict[str, int] = {}

    def packing(self, codes: str) -> str:
        name = self._bound.get(("pack", codes))
        if name is None:
            name = self._name("pack", codes)
            self.names[name] = struct.Struct(f"<{codes}").pack
        return name

    def writer(self, tree: Struct) -> str:
        """Return the name of `write(m) -> bytes`."""
        name = self._bound.get(("write", tree.name))
        if name is None:
            name = self._name("write", tree.name)
            self.function(name, tree)
        return name

    def function(self, name: str, tree: Struct) -> None:
        """Add a function that encodes a message."""
        body = _Body(self)
        body.add_struct("m", tree)
        lines = [*body.lines, f"return {body.joined()}"]
        self.functions += [f"def {name}(m):", *indented(lines, 4)]

    def fields(self, node: Node) -> int:
        """Return how many fields an inline value has."""
        if not isinstance(node, Struct):
            return 1
        count = self._fields.get(node.name)
        if count is None:
            count = sum(self.fields(member.node) for member in node.members) + 1
            self._fields[node.name] = count
        return count

    def _name(self, kind: str, key: str) -> str:
        return self._bound.setdefault((kind, key), f"{kind}_{len(self._bound)}")


class _Body:
    """The body of one function: lines that read and check values, and the parts whose bytes are joined.

    A run is a sequence of fields of constant size that one packing will write.
    """

    def __init__(self, source: _EncoderSource) -> None:
        self.lines: list[str] = []
        self._source = source
        self._parts: list[str] = []
        self._codes: list[str] = []
        self._arguments: list[str] = []
        self._added = 0
        self._variables = 0

    def joined(self) -> str:
        """Return the expression of all bytes."""
        self._end_run()
        if len(self._parts) == 1:
            return self._parts[0]
        return f"b''.join(({', '.join(self._parts)}))" if self._parts else "b''"

    def add_struct(self, variable: str, tree: Struct) -> None:
        """Write the fields of the message that a variable holds."""
        for member in tree.members:
            self._add(attribute(variable, member.name), member.node)

    def _add(self, value: str, node: Node) -> None:
        self._added += 1
        if isinstance(node, Number):
            self._pack(node.code, f"flags[{value}]" if node.code == "?" else value)
        elif isinstance(node, Stamp):
            stamp = self._variable(value)
            self._pack(node.code, f"{stamp}.secs, {stamp}.nsecs")
        elif isinstance(node, Text):
            text = self._variable(f"{value}.encode('utf-8', 'surrogateescape')")
            self._pack("I", f"len({text})")
            self._add_part(text)
        elif isinstance(node, Array):
            self._add_array(self._variable(value), node)
        elif self._added + self._source.fields(node) <= _MAX_FIELDS:
            self.add_struct(self._variable(value), node)
        else:
            self._add_part(f"{self._source.writer(node)}({value})")

    def _add_array(self, array: str, node: Array) -> None:
        element = node.element
        if node.is_bytes:
            self.lines.append(f"if type({array}) is not bytes: {array} = to_bytes({array})")
        if node.length is not None:
            self.lines.append(f"if len({array}) != {node.length}: raise ValueError")
        else:
            self._pack("I", f"len({array})")
            if node.max_count is not None:
                self.lines.append(f"if len({array}) > {node.max_count}: raise ValueError")
        if node.is_bytes and node.length is not None:
            self._pack(f"{node.length}s", array)
        elif node.is_bytes:
            self._add_part(array)
        elif isinstance(element, Number):
            self._add_numbers(array, element, node.length)
        elif isinstance(element, Stamp):
            packing = self._source.packing(element.code)
            self._add_part(f"b''.join([{packing}(x.secs, x.nsecs) for x in {array}])")
        elif isinstance(element, Text):
            self._add_part(f"pack_texts({array})")
        else:
            self._add_part(f"b''.join(map({self._source.writer(element)}, {array}))")

    def _add_numbers(self, array: str, element: Number, length: int | None) -> None:
        values = f"*[flags[x] for x in {array}]" if element.code == "?" else f"*{array}"
        if length is None:
            self._add_part(f"pack(f'<{{len({array})}}{element.code}', {values})")
        elif length:
            self._pack(f"{length}{element.code}", values)

    def _pack(self, codes: str, arguments: str) -> None:
        self._codes.append(codes)
        self._arguments.append(arguments)

    def _add_part(self, expression: str) -> None:
        self._end_run()
        self._parts.append(expression)

    def _end_run(self) -> None:
        if self._codes:
            packing = self._source.packing("".join(self._codes))
            self._parts.append(f"{packing}({', '.join(self._arguments)})")
            self._codes, self._arguments = [], []

    def _variable(self, value: str) -> str:
        self._variables += 1
        name = f"v{self._variables}"
        self.lines.append(f"{name} = {value}")
        return name


def to_bytes(values: object) -> bytes:
    """Return a uint8[] given as bytes or as integers from 0 to 255. Raises TypeError, ValueError."""
    if isinstance(values, bytes | bytearray | memoryview | Sequence) and not isinstance(values, str):
        return bytes(values)
    if hasattr(values, "__array__"):
        # The array of an image may have several dimensions.
        is_bytes = getattr(values, "dtype", None) == "uint8"
        return values.tobytes() if is_bytes else bytes(list(values))  # type: ignore[attr-defined, call-overload]
    raise TypeError("a uint8[] needs bytes or a list of integers")


def _pack_texts(texts: Sequence[str]) -> bytes:
    if isinstance(texts, str | bytes):
        raise TypeError("a string[] needs a list of strings")
    parts = []
    for text in texts:
        raw = text.encode("utf-8", "surrogateescape")
        parts.append(_PACK_U32(len(raw)))
        parts.append(raw)
    return b"".join(parts)


_PACK_U32: Final = struct.Struct("<I").pack
