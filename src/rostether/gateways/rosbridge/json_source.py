"""Generates Python source that converts a message to JSON: one format string per type, filled in one step.

For geometry_msgs/PointStamped the result is:

    def write_0(m):
        v0 = m.header
        v1 = v0.stamp
        v2 = m.point
        v3 = v2.x ...
        if not isfinite(v3 + v4 + v5): raise not_finite
        return '{"header":{"seq":%d,"stamp":{"secs":%d,...},"frame_id":%s},"point":{"x":%r,...}}' % (...)

A sum is finite only if all its numbers are. `NotFiniteError` is raised for numbers that JSON cannot express.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from json.encoder import encode_basestring_ascii
from typing import Any, Final, TypeAlias

from rostether.gateways.rosbridge.values_source import Leaves
from rostether.serde.generated_source import attribute, indented
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message

WriteText: TypeAlias = Callable[[Message], str]

# The limit of values in one format; nested types with more values get their own function.
_MAX_INLINE: Final = 256

# More numbers take longer than a millisecond; other threads can run between the steps.
_MANY_NUMBERS: Final = 1 << 12


class NotFiniteError(Exception):
    """A message has a float that JSON does not support, or floats too large to add up."""


def compile_text(tree: Struct, leaves: Leaves) -> WriteText:
    """Return the function that writes a message of a type; it raises NotFiniteError."""
    source = _TextSource(leaves)
    name = source.writer(tree)
    text = "\n".join(source.functions)
    exec(compile(text, f"<JSON of {tree.name}>", "exec"), source.names)  # noqa: S102
    return source.names[name]  # type: ignore[no-any-return]


def _numbers(values: Sequence[float]) -> str:
    if len(values) <= _MANY_NUMBERS:
        return str(values).replace(" ", "")
    steps = (values[start : start + _MANY_NUMBERS] for start in range(0, len(values), _MANY_NUMBERS))
    return f"[{','.join([str(step)[1:-1].replace(' ', '') for step in steps])}]"


class _TextSource:
    def __init__(self, leaves: Leaves) -> None:
        self.functions: list[str] = []
        self.leaves = leaves
        self.names: dict[str, Any] = {
            "isfinite": math.isfinite,
            "not_finite": NotFiniteError,
            "quote": encode_basestring_ascii,
            "text": leaves.text,
            "raw": leaves.raw,
            "numbers": _numbers,
            "flags": json.JSONEncoder(separators=(",", ":")).encode,
        }
        self._writers: dict[str, str] = {}

    def writer(self, tree: Struct) -> str:
        """Return the name of a type's function."""
        name = self._writers.get(tree.name)
        if name is None:
            body = _Body(self)
            body.struct(tree, "m")
            name = self._writers[tree.name] = f"write_{len(self._writers)}"
            self.functions += [f"def {name}(m):", *indented(body.lines(), 4)]
        return name


class _Body:
    """One function: its format, the values in it, and the floats that must be finite."""

    def __init__(self, source: _TextSource) -> None:
        self._source = source
        self._format: list[str] = []
        self._reads: list[str] = []
        self._values: list[str] = []
        self._floats: list[str] = []
        self._variables = 0

    def lines(self) -> list[str]:
        check = [f"if not isfinite({' + '.join(self._floats)}): raise not_finite"] if self._floats else []
        values = f" % ({', '.join(self._values)},)" if self._values else ""
        return [*self._reads, *check, f"return {''.join(self._format)!r}{values}"]

    def struct(self, tree: Struct, variable: str) -> None:
        """Write the message in a variable."""
        separator = "{"
        for member in tree.members:
            if f"{tree.name}.{member.name}" in self._source.leaves.omitted:
                continue
            self._format.append(f'{separator}"{member.name}":')
            self._value(member.node, attribute(variable, member.name))
            separator = ","
        self._format.append("{}" if separator == "{" else "}")

    def _value(self, node: Node, value: str) -> None:
        if isinstance(node, Array):
            self._array(node, value)
        elif isinstance(node, Number):
            self._number(node, value)
        elif isinstance(node, Text):
            self._put("%s", f"quote(text({value}))")
        elif isinstance(node, Stamp):
            variable = self._read(value)
            # ROS 1 and ROS 2 differ only in the names of a time's two fields.
            first, second = self._source.leaves.stamp((0, 0))
            self._put(f'{{"{first}":%d', f"{variable}[0]")
            self._put(f',"{second}":%d}}', f"{variable}[1]")
        elif len(self._values) + node.zero_elements <= _MAX_INLINE:
            self.struct(node, self._read(value))
        else:
            self._put("%s", f"{self._source.writer(node)}({value})")

    def _number(self, node: Number, value: str) -> None:
        if node.code == "?":
            self._put("%s", f"'true' if {value} else 'false'")
        elif node.code in "fd":
            variable = self._read(value)
            self._floats.append(variable)
            self._put("%r", variable)
        else:
            self._put("%d", value)

    def _array(self, array: Array, value: str) -> None:
        element = array.element
        if array.is_bytes:
            self._put('"%s"', f"raw({value})")
        elif isinstance(element, Number):
            if element.code == "?":
                self._put("%s", f"flags({value})")
                return
            if element.code in "fd":
                value = self._read(value)
                self._floats.append(f"sum({value})")
            self._put("%s", f"numbers({value})")
        elif isinstance(element, Text):
            self._put("[%s]", f"','.join([quote(text(e)) for e in {value}])")
        elif isinstance(element, Struct):
            self._put("[%s]", f"','.join([{self._source.writer(element)}(e) for e in {value}])")
        else:
            first, second = self._source.leaves.stamp((0, 0))
            each = f"""'{{"{first}":%d,"{second}":%d}}' % e"""
            self._put("[%s]", f"','.join([{each} for e in {value}])")

    def _put(self, placeholder: str, value: str) -> None:
        self._format.append(placeholder)
        self._values.append(value)

    def _read(self, value: str) -> str:
        variable = f"v{self._variables}"
        self._variables += 1
        self._reads.append(f"{variable} = {value}")
        return variable
