"""Writes the Python source that checks a type's layout: straight-line code, constant offsets folded.

`accepts(b)` checks one payload, `accepts_all(payloads)` a batch. For sensor_msgs/Imu, the first is:

    def accepts(b):
        try:
            o = 16 + u32(b, 12)[0]
            return o + 296 == len(b)
        except overrun:
            return False

The source never contains a name from a definition, only numbers, so that no definition can inject code.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Final

from rostether.serde.generated_source import indented
from rostether.serde.type_tree import Array, Node, Struct, Text

Accepts = Callable[[bytes], bool]
AcceptsAll = Callable[[Sequence[bytes]], bool]

# The longest function with nested structs inline, in lines; further structs get their own functions.
# Otherwise, the source would grow exponentially if each type contains the next one twice.
_MAX_LINES: Final = 256

# The errors of reading a length beyond the end; wrong lengths may even exceed the range of an offset.
OVERRUN: Final = (struct.error, OverflowError)


def compile_layout(tree: Struct) -> tuple[Accepts, AcceptsAll]:
    """Return the checks of one payload and of a batch, for a type whose size varies."""
    source = _LayoutSource()
    body = _Body(source, "")
    body.add_members(tree)
    accepts = [
        "def accepts(b):",
        "    try:",
        *indented(body.lines, 8),
        f"        return {body.position()} == len(b)",
        "    except overrun:",
        "        return False",
    ]
    accepts_all = [
        "def accepts_all(payloads):",
        "    try:",
        "        for b in payloads:",
        *indented(body.lines, 12),
        f"            if {body.position()} != len(b):",
        "                return False",
        "    except overrun:",
        "        return False",
        "    return True",
    ]
    functions: dict[str, object] = {"u32": struct.Struct("<I").unpack_from, "overrun": OVERRUN}
    text = "\n".join([*source.functions, *accepts, *accepts_all])
    exec(compile(text, f"<layout of {tree.name}>", "exec"), functions)  # noqa: S102
    return functions["accepts"], functions["accepts_all"]  # type: ignore[return-value]


class _LayoutSource:
    """Collects the functions that walk over nested types, each after the functions that it calls."""

    def __init__(self) -> None:
        self.functions: list[str] = []
        self._names: dict[str, str] = {}
        self._reads: dict[str, int] = {}

    def walker(self, tree: Struct) -> str:
        """Return the name of `walk(b, o) -> end`."""
        name = self._names.get(tree.name)
        if name is None:
            body = _Body(self, "o")
            body.add_members(tree)
            name = self._names[tree.name] = f"walk_{len(self._names)}"
            lines = [*body.lines, f"return {body.position()}"]
            self.functions += [f"def {name}(b, o):", *indented(lines, 4)]
        return name

    def reads(self, node: Node) -> int:
        """Return how many length fields are read if a value is checked inline."""
        if not isinstance(node, Struct):
            return int(node.fixed_size_bytes is None)
        count = self._reads.get(node.name)
        if count is None:
            count = sum(self.reads(member.node) for member in node.members)
            self._reads[node.name] = count
        return count


class _Body:
    """The body of one function: lines that walk over the payload `b`.

    The position is the variable `o` plus a constant offset; before the first length field, only the offset.
    """

    def __init__(self, source: _LayoutSource, start: str) -> None:
        self.lines: list[str] = []
        self._source = source
        self._start = start
        self._offset = 0

    def position(self, ahead: int = 0) -> str:
        """Return the expression of the current position, or of a later one."""
        offset = self._offset + ahead
        if not self._start:
            return str(offset)
        return f"{self._start} + {offset}" if offset else self._start

    def add_members(self, tree: Struct) -> None:
        """Walk over the fields of a struct."""
        for member in tree.members:
            self._add(member.node)

    def _add(self, node: Node) -> None:
        if node.fixed_size_bytes is not None:
            self._offset += node.fixed_size_bytes
        elif isinstance(node, Text):
            self._move(f"{self.position(4)} + u32(b, {self.position()})[0]")
        elif isinstance(node, Array):
            self._add_array(node)
        else:
            assert isinstance(node, Struct)
            if len(self.lines) + self._source.reads(node) <= _MAX_LINES:
                self.add_members(node)
            else:
                self._move(f"{self._source.walker(node)}(b, {self.position()})")

    def _add_array(self, array: Array) -> None:
        size = array.element.fixed_size_bytes
        if size is None:
            self._add_varying_elements(array)
        elif array.max_count is not None:
            self.lines.append(f"if u32(b, {self.position()})[0] > {array.max_count}: raise OverflowError")
            self._offset += 4
        else:
            times = f" * {size}" if size != 1 else ""
            self._move(f"{self.position(4)} + u32(b, {self.position()})[0]{times}")

    def _add_varying_elements(self, array: Array) -> None:
        count = str(array.length)
        if array.length is None:
            self.lines.append(f"n = u32(b, {self.position()})[0]")
            self._offset += 4
            count = "n"
        self._move(self.position())
        step = "o += 4 + u32(b, o)[0]"
        if isinstance(array.element, Struct):
            step = f"o = {self._source.walker(array.element)}(b, o)"
        # Every step reads at least one length in the payload, so wrong data cannot prolong this loop.
        self.lines.append(f"for _ in range({count}): {step}")

    def _move(self, expression: str) -> None:
        self.lines.append(f"o = {expression}")
        self._start, self._offset = "o", 0
