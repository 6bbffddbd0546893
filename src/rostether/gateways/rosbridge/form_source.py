"""Generates Python source that converts messages to values or text, with one function per type.

Values are for JSON or CBOR. For geometry_msgs/TwistStamped, the functions are:

    def convert_0(m): return {"x": m.x, "y": m.y, "z": m.z}
    def convert_1(m): return {"linear": convert_0(m.linear), "angular": convert_0(m.angular)}
    def convert_2(m): return {"seq": m.seq, "stamp": stamp(m.stamp), "frame_id": text(m.frame_id)}
    def convert_3(m): return {"header": convert_2(m.header), "twist": convert_1(m.twist)}

Text is JSON: one format string, filled in one step. For geometry_msgs/PointStamped, the function is:

    def convert_0(m):
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
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from enum import Enum
from json.encoder import encode_basestring_ascii
from typing import Any, Final, Generic, TypeAlias, TypeVar

import msgspec

from rostether.serde.codec import Codec
from rostether.serde.generated_source import attribute, indented
from rostether.serde.plain_form import clean_text
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message

ReadValues: TypeAlias = Callable[[Message], dict[str, Any]]
WriteText: TypeAlias = Callable[[Message], str]
FormT = TypeVar("FormT")

# The limit of cached functions of one gateway; definitions come from peers.
_MAX_FORMS: Final = 512

# The limit of values in one format; nested types with more values get their own function.
_MAX_INLINE: Final = 256

# More numbers take longer than a millisecond; other threads can run between the steps.
_MANY_NUMBERS: Final = 1 << 12


class Style(Enum):
    """Whether fields have the names of ROS 1 or ROS 2; each value has the names of the fields of a time."""

    ROS1 = ("secs", "nsecs")
    ROS2 = ("sec", "nanosec")

    def omits(self, type_name: str, field: str) -> bool:
        """Return whether clients do not expect a field."""
        return self is Style.ROS2 and (type_name, field) == ("std_msgs/Header", "seq")


class Leaves(msgspec.Struct, frozen=True):
    """Converts the values that are not messages; `style` is the form of times.

    `raw` converts bytes. `numbers` returns the function for arrays of numbers, given the `struct` format of
    an element; None keeps them as lists.
    """

    style: Style
    raw: Callable[[bytes], Any]
    numbers: Callable[[str], Callable[[list[Any]], Any]] | None = None


class CompiledForms(Generic[FormT]):
    """A cache of the functions from `compile_form`, one for each type."""

    def __init__(self, compile_form: Callable[[Struct, Leaves], FormT], leaves: Leaves) -> None:
        self._compile = compile_form
        self._leaves = leaves
        self._forms: dict[Codec, FormT] = {}

    def of(self, codec: Codec) -> FormT:
        """Return the function of a codec's type."""
        form = self._forms.get(codec)
        if form is None:
            if len(self._forms) >= _MAX_FORMS:
                del self._forms[next(iter(self._forms))]
            form = self._forms[codec] = self._compile(codec.tree, self._leaves)
        return form


class NotFiniteError(Exception):
    """A message has a float that JSON does not support, or floats too large to add up."""


def compile_values(tree: Struct, leaves: Leaves) -> ReadValues:
    """Return the function that converts a message of a type to a dict, with its fields in order."""
    return _ValuesSource(leaves).compiled(tree)  # type: ignore[no-any-return]


def compile_text(tree: Struct, leaves: Leaves) -> WriteText:
    """Return the function that writes a message of a type; it raises NotFiniteError."""
    return _TextSource(leaves).compiled(tree)  # type: ignore[no-any-return]


class _Source(ABC):
    """The source of the functions of a type and its nested types; `names` are the globals of the source."""

    def __init__(self, leaves: Leaves) -> None:
        self.leaves = leaves
        self.names: dict[str, Any] = {"text": clean_text, "raw": leaves.raw}
        self._functions: list[str] = []
        self._known: dict[str, str] = {}

    def compiled(self, tree: Struct) -> Any:
        name = self.function(tree)
        exec(compile("\n".join(self._functions), f"<form of {tree.name}>", "exec"), self.names)  # noqa: S102
        return self.names[name]

    def function(self, tree: Struct) -> str:
        name = self._known.get(tree.name)
        if name is None:
            body = self._body(tree)
            name = self._known[tree.name] = f"convert_{len(self._known)}"
            self._functions += [f"def {name}(m):", *indented(body, 4)]
        return name

    @abstractmethod
    def _body(self, tree: Struct) -> list[str]: ...


class _ValuesSource(_Source):
    def __init__(self, leaves: Leaves) -> None:
        super().__init__(leaves)
        first, second = leaves.style.value
        self.names["stamp"] = lambda value: {first: value[0], second: value[1]}

    def _body(self, tree: Struct) -> list[str]:
        fields = ", ".join(
            f'"{member.name}": {self._value(member.node, attribute("m", member.name))}'
            for member in tree.members
            if not self.leaves.style.omits(tree.name, member.name)
        )
        return [f"return {{{fields}}}"]

    def _value(self, node: Node, value: str) -> str:
        if isinstance(node, Number):
            return value
        if isinstance(node, Array):
            return self._array(node, value)
        return f"{self._single(node)}({value})"

    def _array(self, array: Array, value: str) -> str:
        element = array.element
        if array.is_bytes:
            return f"raw({value})"
        if not isinstance(element, Number):
            return f"[{self._single(element)}(e) for e in {value}]"
        if element.code == "?" or self.leaves.numbers is None:
            return value
        name = f"numbers_{element.code}"
        self.names[name] = self.leaves.numbers(element.code)
        return f"{name}({value})"

    def _single(self, node: Stamp | Text | Struct) -> str:
        if isinstance(node, Struct):
            return self.function(node)
        return "stamp" if isinstance(node, Stamp) else "text"


class _TextSource(_Source):
    def __init__(self, leaves: Leaves) -> None:
        super().__init__(leaves)
        self.names |= {
            "isfinite": math.isfinite,
            "not_finite": NotFiniteError,
            "quote": encode_basestring_ascii,
            "numbers": _numbers,
            "flags": json.JSONEncoder(separators=(",", ":")).encode,
        }

    def _body(self, tree: Struct) -> list[str]:
        body = _Body(self)
        body.struct(tree, "m")
        return body.lines()


def _numbers(values: Sequence[float]) -> str:
    if len(values) <= _MANY_NUMBERS:
        return str(values).replace(" ", "")
    steps = (values[start : start + _MANY_NUMBERS] for start in range(0, len(values), _MANY_NUMBERS))
    return f"[{','.join([str(step)[1:-1].replace(' ', '') for step in steps])}]"


class _Body:
    """One function: its format, the values in it, and the floats that must be finite."""

    def __init__(self, source: _TextSource) -> None:
        self._source = source
        self._seconds, self._nanoseconds = source.leaves.style.value
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
        separator = "{"
        for member in tree.members:
            if self._source.leaves.style.omits(tree.name, member.name):
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
            self._put(f'{{"{self._seconds}":%d', f"{variable}[0]")
            self._put(f',"{self._nanoseconds}":%d}}', f"{variable}[1]")
        elif len(self._values) + node.zero_elements <= _MAX_INLINE:
            self.struct(node, self._read(value))
        else:
            self._put("%s", f"{self._source.function(node)}({value})")

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
            self._put("[%s]", f"','.join([{self._source.function(element)}(e) for e in {value}])")
        else:
            each = f"""'{{"{self._seconds}":%d,"{self._nanoseconds}":%d}}' % e"""
            self._put("[%s]", f"','.join([{each} for e in {value}])")

    def _put(self, placeholder: str, value: str) -> None:
        self._format.append(placeholder)
        self._values.append(value)

    def _read(self, value: str) -> str:
        variable = f"v{self._variables}"
        self._variables += 1
        self._reads.append(f"{variable} = {value}")
        return variable
