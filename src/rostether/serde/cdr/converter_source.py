"""Writes the Python source that turns ROS 1 serialization into CDR, or CDR into ROS 1 serialization.

`convert(b)` is straight-line code: what both sides have alike is one slice. For sensor_msgs/Imu, to CDR:

    def convert(b):
        try:
            n0, = u32(b, 12)
            o1 = 16 + n0
            c2 = (20 + n0 & -8) + 4                      # where the float64s begin
            if o1 + 296 != len(b): raise overrun
            return join((b'\\0\\1\\0\\0', b[4:12], pack(n0 + 1), b[16:o1], nul8[17 + n0 & 7], b[o1:o1 + 296]))
        except errors:
            return refuse(b)

Source never contains a name from a definition, only numbers, so that no definition can inject code.
Pieces are joined once the lengths are known to add up, and loops run over no more elements than there are
bytes for: nothing is allocated for a length that is only announced.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

from rostether.serde.cdr.pair_tree import (
    DUMMY_NAME,
    Array,
    Node,
    Plain,
    Record,
    Side,
    Slot,
    Text,
    Translation,
)
from rostether.serde.cdr.pieces import Pieces
from rostether.serde.cdr.place import Place
from rostether.serde.generated_source import indented
from rostether.serde.type_tree import MAX_EMPTY_ELEMENTS

Convert = Callable[[bytes], bytes]

LITTLE_ENDIAN: Final = b"\0\1\0\0"
"""The encapsulation of what we write: plain CDR, little endian, no options."""

ERRORS: Final = (struct.error, OverflowError, IndexError)
"""What reading bytes of another layout raises."""

_MAX_LINES: Final = 256
"""How many lines a function grows to by nested records inline; further ones become functions of their own, so
that a type holding a type twice, which holds one twice ..., does not double the source at each level."""

_PADS: Final = {
    f"{name}{alignment}": tuple(
        nul + bytes(((4 if alignment == 8 else 0) - index) % alignment) for index in range(alignment)
    )
    for name, nul in (("pad", b""), ("nul", b"\0"))
    for alignment in (2, 4, 8)
}
"""The zeros up to the next aligned index, by the index modulo the alignment; `nul...` end a text as well."""


def compile_conversion(tree: Record, target: Side, refuse: Callable[[bytes], bytes]) -> Convert:
    """Return a conversion of one payload to a side; what does not fit, or is other CDR, goes to `refuse`."""
    source = _Source(target)
    cdr = target is Side.ROS2
    body = _Body(source, Place("", 0 if cdr else 4, aligned=not cdr), Place("", 4, aligned=cdr))
    if cdr:
        body.pieces.add_constant(LITTLE_ENDIAN)
    body.convert(tree)
    end = body.source_place.text()
    lines = [*body.lines, f"if {end} {'!=' if cdr else '>'} len(b): raise overrun"]
    if not cdr:
        lines.insert(0, f"if b[:2] != {LITTLE_ENDIAN[:2]!r}: return refuse(b)")
        if [slot.ros2_name for slot in tree.ros2_slots] == [DUMMY_NAME]:
            # Some peers leave out the byte that stands for no field at all.
            lines.pop()
    pieces = body.pieces.take()
    if body.uses_out:
        lines = ["out = []", *lines, f"out += ({_row(pieces)})", "return join(out)"]
    else:
        lines.append(f"return join(({_row(pieces)}))")
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
    exec(compile(text, f"<{target.value} of {tree.name}>", "exec"), names)  # noqa: S102
    return names["convert"]  # type: ignore[no-any-return]


class _Source:
    """Collects the functions of nested types, and the names that all source refers to."""

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
            **_PADS,
        }
        self._named: dict[tuple[str, int], str] = {}
        self._alive: list[object] = []
        self._lines: dict[int, int] = {}

    def table(self, translation: Translation) -> str:
        """Return the name of a translation's table."""
        name = self._name("table", translation)
        self.names[name] = translation.to_ros2 if self.target is Side.ROS2 else translation.to_ros1
        return name

    def converter(self, node: Node) -> str:
        """Return the name of `convert_n(b, o, c, out) -> (o, c)`, the ends of what it read and wrote."""
        if ("convert", id(node)) in self._named:
            return self._named["convert", id(node)]
        name = self._name("convert", node)
        body = self._function_body()
        body.convert_inline(node)
        if body.pieces:
            body.flush()
        lines = [*body.lines, f"return {body.source_place.text()}, {body.target_place.text()}"]
        self.functions += [f"def {name}(b, o, c, out):", *indented(lines, 4)]
        return name

    def walker(self, node: Node) -> str:
        """Return the name of `walk_n(b, o) -> o`, which reads over a value."""
        if ("walk", id(node)) in self._named:
            return self._named["walk", id(node)]
        name = self._name("walk", node)
        body = self._function_body()
        body.skip_inline(node)
        lines = [*body.lines, f"return {body.source_place.text()}"]
        self.functions += [f"def {name}(b, o):", *indented(lines, 4)]
        return name

    def lines(self, node: Node) -> int:
        """Return about how many lines converting a value inline takes."""
        if not isinstance(node, Record):
            return int(node.block is None)
        count = self._lines.get(id(node))
        if count is None:
            count = sum(self.lines(slot.node) for slot in {*node.ros1_slots, *node.ros2_slots})
            self._lines[id(node)] = count
        return count

    def _function_body(self) -> _Body:
        cdr = self.target is Side.ROS2
        return _Body(
            self,
            Place("o", 0, aligned=not cdr, modulus=1),
            Place("c", 0, aligned=cdr, modulus=1),
        )

    def _name(self, kind: str, key: object) -> str:
        self._alive.append(key)
        return self._named.setdefault((kind, id(key)), f"{kind}_{len(self._named)}")


class _Body:
    """The body of one function: lines that find out lengths, and the pieces that they delimit."""

    def __init__(self, source: _Source, source_place: Place, target_place: Place) -> None:
        self.lines: list[str] = []
        self.pieces = Pieces()
        self.uses_out = False
        self.source_place = source_place
        self.target_place = target_place
        self._source = source
        self._count = 0
        self._to_cdr = source.target is Side.ROS2
        self._from = Side.ROS1 if self._to_cdr else Side.ROS2

    def convert(self, node: Node) -> None:
        """Convert one value, by a function of its own if this one has become long."""
        if node.block is None and len(self.lines) + self._source.lines(node) > _MAX_LINES:
            self._call_converter(self._source.converter(node))
        else:
            self.convert_inline(node)

    def convert_inline(self, node: Node) -> None:
        """Convert one value here."""
        if node.block is not None:
            self._copy(node.block.size_bytes, node.block.alignment)
        elif isinstance(node, Plain):
            self._translate(node, node.size_bytes)
        elif isinstance(node, Text):
            self._convert_text(node)
        elif isinstance(node, Array):
            self._convert_array(node)
        else:
            self._convert_record(node)

    def skip(self, node: Node) -> None:
        """Read over one value, by a function of its own if this one has become long."""
        if isinstance(node, Record) and len(self.lines) + self._source.lines(node) > _MAX_LINES:
            place = self.source_place
            place.move(self._line("o", f"{self._source.walker(node)}(b, {place.text()})"))
        else:
            self.skip_inline(node)

    def skip_inline(self, node: Node) -> None:
        """Read over one value here."""
        place = self.source_place
        size = node.ros1_size_bytes if self._to_cdr else None
        if size is not None:
            place.advance(size)
        elif node.block is not None or isinstance(node, Plain):
            block = node.block
            self._align_source(block.alignment if block else 1)
            place.advance(block.size_bytes if block else 1)
        elif isinstance(node, Text):
            count = self._read_count(None)
            place.move(self._line("o", f"{place.text()} + {count}"))
        elif isinstance(node, Array):
            self._skip_array(node)
        else:
            for slot in node.slots(self._from):
                self.skip(slot.node)

    def flush(self) -> None:
        """Put the pieces so far to the output of loops and functions."""
        self.uses_out = True
        if self.pieces:
            self.lines.append(f"out += ({_row(self.pieces.take())})")

    def _convert_record(self, record: Record) -> None:
        to = Side.ROS2 if self._to_cdr else Side.ROS1
        if record.is_ordered:
            self._convert_in_step(record, to)
            return
        places: dict[int, Place] = {}
        for slot in record.slots(self._from):
            self.source_place.move(self._line("o", self.source_place.text()), 8)
            places[id(slot)] = self.source_place.copy()
            self.skip(slot.node)
        end = self.source_place.copy()
        for slot in record.slots(to):
            if slot.side is Side.BOTH:
                self.source_place = places[id(slot)]
                self.convert(slot.node)
            else:
                self._add_default(slot)
        self.source_place = end

    def _convert_in_step(self, record: Record, to: Side) -> None:
        waiting = list(record.slots(to))
        for slot in record.slots(self._from):
            while waiting and waiting[0].side is to:
                self._add_default(waiting.pop(0))
            if slot.side is Side.BOTH:
                waiting.pop(0)
                self.convert(slot.node)
            else:
                self.skip(slot.node)
        for slot in waiting:
            self._add_default(slot)

    def _add_default(self, slot: Slot) -> None:
        if not self._to_cdr:
            self.pieces.add_constant(_zero(slot.node))
            return
        for alignment, value in slot.default:
            self._align_target(alignment)
            self.pieces.add_constant(value)
            self.target_place.advance(len(value))

    def _copy(self, size: int, alignment: int) -> None:
        self._align_source(alignment)
        self._align_target(alignment)
        start = self.source_place.text()
        self.source_place.advance(size)
        self.target_place.advance(size)
        self.pieces.add_slice(start, self.source_place.text())

    def _translate(self, node: Plain, size: int) -> None:
        assert node.translation is not None
        table = self._source.table(node.translation)
        self.pieces.add_expression(
            f"b[{self.source_place.text()}:{self.source_place.text(size)}].translate({table})"
        )
        self.source_place.advance(size)
        self.target_place.advance(size)

    def _convert_text(self, text: Text) -> None:
        self._align_target(4)
        place, target = self.source_place, self.target_place
        count = self._read_count(text.bound if self._to_cdr else None)
        start = place.text()
        end = self._line("o", f"{start} + {count}")
        if self._to_cdr:
            self.pieces.add_expression(f"pack({count} + 1)")
            self.pieces.add_slice(start, end)
            self.pieces.add_constant(b"\0")
            target.move(f"{target.text(5)} + {count}")
        else:
            stop = self._line("o", f"{end} - 1 if {count} and not b[{end} - 1] else {end}")
            length = f"{stop} - {place.text()}" if not place.start else f"{stop} - ({place.text()})"
            self.pieces.add_expression(f"pack({length})")
            self.pieces.add_slice(start, stop)
        place.move(end)

    def _convert_array(self, array: Array) -> None:
        element = array.element
        if array.length is not None:
            if array.length and isinstance(element, Plain):
                self._translate(element, array.length)
            elif array.length:
                self._loop(element, str(array.length))
            return
        self._align_source(4)
        self._align_target(4)
        start = self.source_place.text()
        count = self._read_count(array.bound if self._to_cdr else None)
        self.pieces.add_slice(start, self.source_place.text())
        self.target_place.advance(4)
        block = element.block
        if block is not None:
            self._copy_elements(count, block.size_bytes, block.alignment)
        elif isinstance(element, Plain):
            assert element.translation is not None
            start = self.source_place.text()
            end = self._line("o", f"{start} + {count}")
            self.pieces.add_expression(
                f"b[{start}:{end}].translate({self._source.table(element.translation)})"
            )
            self.source_place.move(end)
            self.target_place.move(f"{self.target_place.text()} + {count}")
        else:
            self._limit(element, count)
            self._loop(element, count)

    def _copy_elements(self, count: str, size: int, alignment: int) -> None:
        """Copy a sequence of blocks: before the first there is padding, but not if there is none."""
        self._align_if(self.source_place, count, alignment)
        if self.target_place.padding(alignment) != 0:
            before = self._line("c", self.target_place.text())
            self.target_place.move(before, 8)
            self.pieces.add_expression(f"pad{alignment}[{before} & {alignment - 1}] if {count} else b''")
            self._align_if(self.target_place, count, alignment)
        length = f"{count} * {size}" if size > 1 else count
        start = self.source_place.text()
        end = self._line("o", f"{start} + {length}")
        self.source_place.move(end, size)
        self.pieces.add_slice(start, end)
        self.target_place.move(f"{self.target_place.text()} + {length}", size)

    def _align_if(self, place: Place, count: str, alignment: int) -> None:
        if place.padding(alignment) == 0:
            return
        # Behind the count the place is a multiple of four; only values of eight bytes get here.
        before = place.text()
        variable = self._variable("o")
        self.lines.append(f"{place.align(variable, alignment)} if {count} else {before}")
        place.modulus = min(alignment, 4)

    def _limit(self, element: Node, count: str) -> None:
        """Refuse counts of elements that there are no bytes for."""
        least = element.least_bytes(self._from)
        if element.least_bytes(Side.ROS1) == 0:
            self.lines.append(f"if {count} > {MAX_EMPTY_ELEMENTS}: raise overrun")
        if least:
            self.lines.append(f"if {count} * {least} > len(b) - ({self.source_place.text()}): raise overrun")

    def _loop(self, element: Node, count: str) -> None:
        name = self._source.converter(element)
        self.flush()
        before, after = self._variable("o"), self._variable("c")
        target = self.target_place.text() if self._to_cdr else "0"
        self.lines.append(f"{before} = {self.source_place.text()}")
        self.lines.append(f"{after} = {target}")
        self.lines.append(f"for _ in range({count}): {before}, {after} = {name}(b, {before}, {after}, out)")
        self.source_place.move(before)
        self.target_place.move(after)

    def _call_converter(self, name: str) -> None:
        self.flush()
        end, target_end = self._variable("o"), self._variable("c")
        target = self.target_place.text() if self._to_cdr else "0"
        self.lines.append(f"{end}, {target_end} = {name}(b, {self.source_place.text()}, {target}, out)")
        self.source_place.move(end)
        self.target_place.move(target_end)

    def _skip_array(self, array: Array) -> None:
        element, place = array.element, self.source_place
        count = str(array.length)
        if array.length is None:
            count = self._read_count(None)
            size = element.ros1_size_bytes if self._to_cdr else None
            if size is not None:
                place.move(self._line("o", f"{place.text()} + {count} * {size}"))
                return
            block = element.block or (Plain(1, 1).block if isinstance(element, Plain) else None)
            if block is not None:
                self._align_if(place, count, block.alignment)
                place.move(
                    self._line("o", f"{place.text()} + {count} * {block.size_bytes}"), block.size_bytes
                )
                return
            self._limit(element, count)
        elif isinstance(element, Plain):
            place.advance(array.length)
            return
        name = self._source.walker(element)
        variable = self._line("o", place.text())
        self.lines.append(f"for _ in range({count}): {variable} = {name}(b, {variable})")
        place.move(variable)

    def _read_count(self, bound: int | None) -> str:
        """Read a length, and refuse one over its bound."""
        self._align_source(4)
        count = self._variable("n")
        self.lines.append(f"{count}, = u32(b, {self.source_place.text()})")
        if bound is not None:
            self.lines.append(f"if {count} > {bound}: raise overrun")
        self.source_place.advance(4)
        return count

    def _align_source(self, alignment: int) -> None:
        padding = self.source_place.padding(alignment)
        if padding is not None:
            self.source_place.advance(padding)
        else:
            self.lines.append(self.source_place.align(self._variable("o"), alignment))

    def _align_target(self, alignment: int) -> None:
        place = self.target_place
        padding = place.padding(alignment)
        if padding is not None:
            self.pieces.add_constant(bytes(padding))
            place.advance(padding)
            return
        pads = "nul" if self.pieces.take_final_nul() else "pad"
        self.pieces.add_expression(f"{pads}{alignment}[{place.text()} & {alignment - 1}]")
        self.lines.append(place.align(self._variable("c"), alignment))

    def _line(self, prefix: str, expression: str) -> str:
        variable = self._variable(prefix)
        self.lines.append(f"{variable} = {expression}")
        return variable

    def _variable(self, prefix: str) -> str:
        self._count += 1
        return f"{prefix}{self._count - 1}"


def _row(pieces: list[str]) -> str:
    return "".join(f"{piece}, " for piece in pieces)


def _zero(node: Node) -> bytes:
    """Return the ROS 1 bytes of a field that only ROS 1 has."""
    if isinstance(node, Plain):
        return bytes(node.size_bytes)
    if isinstance(node, Text):
        return bytes(4)
    if isinstance(node, Array):
        return bytes(4) if node.length is None else node.length * _zero(node.element)
    return b"".join(_zero(slot.node) for slot in node.ros1_slots)
