"""Writes the Python source that turns ROS 1 serialization into CDR, or CDR into ROS 1 serialization.

`convert(b)` is straight-line code: equal bytes of both sides are one slice. For sensor_msgs/Imu, to CDR:

    def convert(b):
        try:
            n0, = u32(b, 12)
            o1 = 16 + n0
            c2 = (17 + n0 + 3 & -8) + 4                  # where the float64s begin there
            if o1 + 296 != len(b): raise overrun
            return join((b'\\0\\1\\0\\0', b[4:12], pack(n0 + 1), b[16:o1], nul8[17 + n0 & 7], b[o1:o1 + 296]))
        except errors:
            return refuse(b)

The source never contains a name from a definition, only numbers, so that no definition can inject code.
Pieces are joined after all lengths were checked, and loops never have more elements than the payload has
bytes for. So an announced length alone allocates nothing.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

from rostether.errors import DefinitionError
from rostether.serde.cdr.conversion_tree import Node, Record, Side, Translation
from rostether.serde.cdr.converting_body import ConvertingBody, row
from rostether.serde.cdr.offset import Offset, narrow, widen
from rostether.serde.generated_source import indented

Convert = Callable[[bytes], bytes]

# The encapsulation of written CDR: plain, little endian, no options.
LITTLE_ENDIAN: Final = b"\0\1\0\0"

# The exceptions of reading bytes with another layout.
ERRORS: Final = (struct.error, OverflowError, IndexError)

# The zeros up to the next aligned index, by the index modulo the alignment; `nul...` start with the NUL that
# ends a string.
_PADS: Final = {
    f"{name}{alignment}": tuple(
        nul + bytes(((4 if alignment == 8 else 0) - index) % alignment) for index in range(alignment)
    )
    for name, nul in (("pad", b""), ("nul", b"\0"))
    for alignment in (2, 4, 8)
}


def compile_conversion(tree: Record, target: Side, refuse: Callable[[bytes], bytes]) -> Convert:
    """Return a conversion of one payload to a side; `refuse` gets payloads that do not fit, or other CDR.

    Raises DefinitionError for a type with thousands of arrays.
    """
    source = _Source(target)
    to_cdr = target is Side.ROS2
    body = source.body("", 0 if to_cdr else 4, "", 4, modulus=8)
    if to_cdr:
        body.pieces.add_constant(LITTLE_ENDIAN)
    body.convert_inline(tree)
    end = body.source_at.text()
    lines = [*body.lines, f"if {end} {'!=' if to_cdr else '>'} len(b): raise overrun"]
    if not to_cdr:
        lines.insert(0, f"if b[:2] != {LITTLE_ENDIAN[:2]!r}: return refuse(b)")
        if tree.is_empty_in_ros2:
            # Some peers omit the placeholder byte of an empty message.
            lines.pop()
    pieces = body.pieces.pop_all()
    if body.uses_out:
        lines = ["out = []", *lines, f"out += ({row(pieces)})", "return join(out)"]
    else:
        lines.append(f"return join(({row(pieces)}))")
    text = "\n".join(
        [
            *source.functions,
            "def convert(b):",
            "    try:",
            *indented(lines, 8),
            "    except errors:",
            "        return refuse(b)",
        ]
    )
    names = source.names | {"refuse": refuse}
    try:
        exec(compile(text, f"<{target.value} of {tree.name}>", "exec"), names)  # noqa: S102
    except RecursionError:
        # Python's compiler fails with several thousand branches in one function.
        raise DefinitionError(f"{tree.name} has too many arrays for ROS 2; split it") from None
    return names["convert"]  # type: ignore[no-any-return]


class _Source:
    """Collects the functions of nested types, and the names that the source refers to."""

    def __init__(self, target: Side) -> None:
        self.target = target
        self.functions: list[str] = []
        u32 = struct.Struct("<I")
        self.names: dict[str, Any] = {
            "u32": u32.unpack_from,
            "pack": u32.pack,
            "join": b"".join,
            "errors": ERRORS,
            "overrun": struct.error,
            "widen": widen,
            "narrow": narrow,
            **_PADS,
        }
        self._named: dict[tuple[str, int], str] = {}
        self._alive: list[object] = []
        self._parts: dict[int, int] = {}

    def table(self, translation: Translation) -> str:
        """Return the name of a translation's table."""
        name = self._name("table", translation)
        self.names[name] = translation.to_ros2 if self.target is Side.ROS2 else translation.to_ros1
        return name

    def converter(self, node: Node) -> str:
        """Return the name of `convert_n(b, o, c, out) -> (o, c)`, the ends of its input and output."""
        if ("convert", id(node)) in self._named:
            return self._named["convert", id(node)]
        name = self._name("convert", node)
        body = self.body("o", 0, "c", 0, modulus=1)
        body.convert_inline(node)
        if body.pieces:
            body.flush()
        lines = [*body.lines, f"return {body.source_at.text()}, {body.target_at.text()}"]
        self.functions += [f"def {name}(b, o, c, out):", *indented(lines, 4)]
        return name

    def walker(self, node: Node) -> str:
        """Return the name of `walk_n(b, o) -> o`, which skips a value."""
        if ("walk", id(node)) in self._named:
            return self._named["walk", id(node)]
        name = self._name("walk", node)
        body = self.body("o", 0, "c", 0, modulus=1)
        body.skip_inline(node)
        lines = [*body.lines, f"return {body.source_at.text()}"]
        self.functions += [f"def {name}(b, o):", *indented(lines, 4)]
        return name

    def part_count(self, node: Node) -> int:
        """Return how many parts the inline conversion of a value needs."""
        if not isinstance(node, Record) or node.block is not None:
            return 1
        count = self._parts.get(id(node))
        if count is None:
            count = sum(self.part_count(slot.node) for slot in {*node.ros1_slots, *node.ros2_slots})
            self._parts[id(node)] = count
        return count

    def body(
        self, source_start: str, source_offset: int, target_start: str, target_offset: int, *, modulus: int
    ) -> ConvertingBody:
        """Return the body of a function; the index into CDR is a multiple of `modulus`."""
        to_cdr = self.target is Side.ROS2
        return ConvertingBody(
            self,
            Side.ROS1 if to_cdr else Side.ROS2,
            Offset(source_start, source_offset, is_aligned=not to_cdr, modulus=modulus),
            Offset(target_start, target_offset, is_aligned=to_cdr, modulus=modulus),
        )

    def _name(self, kind: str, key: object) -> str:
        self._alive.append(key)
        return self._named.setdefault((kind, id(key)), f"{kind}_{len(self._named)}")
