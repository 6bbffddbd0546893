"""Generates Python source that converts a message to JSON or CBOR values: one function per type.

For geometry_msgs/TwistStamped the result is:

    def read_0(m): return {"x": m.x, "y": m.y, "z": m.z}
    def read_1(m): return {"linear": read_0(m.linear), "angular": read_0(m.angular)}
    def read_2(m): return {"seq": m.seq, "stamp": stamp(m.stamp), "frame_id": text(m.frame_id)}
    def read_3(m): return {"header": read_2(m.header), "twist": read_1(m.twist)}
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, Generic, TypeAlias, TypeVar

import msgspec

from rostether.serde.codec import Codec
from rostether.serde.generated_source import attribute
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message

ReadValues: TypeAlias = Callable[[Message], dict[str, Any]]
FormT = TypeVar("FormT")

# The limit of cached functions of one gateway; definitions come from peers.
_MAX_FORMS: Final = 512


class Leaves(msgspec.Struct, frozen=True):
    """Converts the values that are not messages.

    `numbers` returns the function for arrays of numbers, given the `struct` format of an element; None keeps
    them as lists. `omitted` are fields, as `package/Name.field`, that the form omits.
    """

    stamp: Callable[[Any], Any]
    text: Callable[[str], Any]
    raw: Callable[[bytes], Any]
    numbers: Callable[[str], Callable[[list[Any]], Any]] | None = None
    omitted: frozenset[str] = frozenset()


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


def compile_values(tree: Struct, leaves: Leaves) -> ReadValues:
    """Return the function that converts a message of a type to a dict, with its fields in order."""
    source = _ValuesSource(leaves)
    name = source.reader(tree)
    text = "\n".join(source.functions)
    exec(compile(text, f"<values of {tree.name}>", "exec"), source.names)  # noqa: S102
    return source.names[name]  # type: ignore[no-any-return]


class _ValuesSource:
    def __init__(self, leaves: Leaves) -> None:
        self.functions: list[str] = []
        self.names: dict[str, Any] = {"stamp": leaves.stamp, "text": leaves.text, "raw": leaves.raw}
        self._leaves = leaves
        self._readers: dict[str, str] = {}

    def reader(self, tree: Struct) -> str:
        """Return the name of a type's function."""
        name = self._readers.get(tree.name)
        if name is None:
            fields = ", ".join(
                f'"{member.name}": {self._value(member.node, attribute("m", member.name))}'
                for member in tree.members
                if f"{tree.name}.{member.name}" not in self._leaves.omitted
            )
            name = self._readers[tree.name] = f"read_{len(self._readers)}"
            self.functions.append(f"def {name}(m): return {{{fields}}}")
        return name

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
        if element.code == "?" or self._leaves.numbers is None:
            return value
        name = f"numbers_{element.code}"
        self.names[name] = self._leaves.numbers(element.code)
        return f"{name}({value})"

    def _single(self, node: Stamp | Text | Struct) -> str:
        if isinstance(node, Struct):
            return self.reader(node)
        return "stamp" if isinstance(node, Stamp) else "text"
