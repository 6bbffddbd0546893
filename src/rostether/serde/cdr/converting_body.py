"""Generated code that converts values: equal bytes of both sides are one slice, other values a few lines."""

from __future__ import annotations

from math import gcd
from typing import Final

from rostether.serde.cdr.conversion_tree import Array, Node, Plain, Record, Side, Slot, Text
from rostether.serde.cdr.offset import UNIT_BYTES, Offset
from rostether.serde.cdr.output_pieces import OutputPieces
from rostether.serde.cdr.reading_body import Functions, ReadingBody
from rostether.serde.generated_source import indented

# The depth of nested loops; elements of deeper loops get separate functions.
_MAX_LOOPS: Final = 2


class ConvertingBody(ReadingBody):
    """The body of one function: lines that read lengths, and the pieces between them.

    `side` is the input's side, with the position `source_at`; `target_at` is the position in the output.
    """

    def __init__(
        self, functions: Functions, side: Side, source_at: Offset, target_at: Offset, *, loops: int = 0
    ) -> None:
        super().__init__(functions, side, source_at)
        self._loops = loops
        self.pieces = OutputPieces()
        self.uses_out = False
        self.target_at = target_at

    def convert(self, node: Node) -> None:
        """Convert one value, in a separate function if this one has become long."""
        if isinstance(node, Record) and node.block is None and self.is_long_with(node):
            self._call_converter(self.functions.converter(node))
        else:
            self.convert_inline(node)

    def convert_inline(self, node: Node) -> None:
        """Convert one value in this function."""
        self.parts += node.block is not None or not isinstance(node, Record)
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

    def flush(self) -> None:
        """Add the pieces so far to the output of loops and functions."""
        self.uses_out = True
        if self.pieces:
            self.lines.append(f"out += ({row(self.pieces.pop_all())})")

    def _convert_record(self, record: Record) -> None:
        to = Side.ROS2 if self.to_cdr else Side.ROS1
        if record.is_ordered:
            self._convert_in_step(record, to)
            return
        offsets: dict[int, Offset] = {}
        for slot in record.slots(self.side):
            self.source_at.move(self.line("o", self.source_at.text()), 8)
            offsets[id(slot)] = self.source_at.copy()
            self.skip(slot.node)
        end = self.source_at.copy()
        for slot in record.slots(to):
            if slot.side is Side.BOTH:
                self.source_at = offsets[id(slot)]
                self.convert(slot.node)
            else:
                self._add_default(slot)
        self.source_at = end

    def _convert_in_step(self, record: Record, to: Side) -> None:
        waiting = list(record.slots(to))
        for slot in record.slots(self.side):
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
        if not self.to_cdr:
            self.pieces.add_constant(_zero(slot.node))
            return
        for alignment, value in slot.default:
            self._align_target(alignment)
            self.pieces.add_constant(value)
            self.target_at.advance(len(value))

    def _copy(self, size: int, alignment: int) -> None:
        self.align_source(alignment)
        self._align_target(alignment)
        start = self.source_at.text()
        self.source_at.advance(size)
        self.target_at.advance(size)
        self.pieces.add_slice(start, self.source_at.text())

    def _translate(self, node: Plain, size: int) -> None:
        assert node.translation is not None
        table = self.functions.table(node.translation)
        self.pieces.add_expression(
            f"b[{self.source_at.text()}:{self.source_at.text(size)}].translate({table})"
        )
        self.source_at.advance(size)
        self.target_at.advance(size)

    def _convert_text(self, text: Text) -> None:
        self._align_target(4)
        if text.is_wide:
            self._convert_wide_text(text)
            return
        offset, target = self.source_at, self.target_at
        count = self.read_count(text.bound if self.to_cdr else None)
        start = offset.text()
        end = self.line("o", f"{start} + {count}")
        if self.to_cdr:
            self.pieces.add_expression(f"pack({count} + 1)")
            self.pieces.add_slice(start, end)
            self.pieces.add_constant(b"\0")
            target.move(f"{target.text(5)} + {count}")
        else:
            stop = self.line("o", f"{end} - 1 if {count} and not b[{end} - 1] else {end}")
            length = f"{stop} - {offset.text()}" if not offset.start else f"{stop} - ({offset.text()})"
            self.pieces.add_expression(f"pack({length})")
            self.pieces.add_slice(start, stop)
        offset.move(end)

    def _convert_wide_text(self, text: Text) -> None:
        offset, target = self.source_at, self.target_at
        count = self.read_count(None)
        start = offset.text()
        if self.to_cdr:
            end = self.line("o", f"{start} + {count}")
            units = self.line("w", f"widen(b[{start}:{end}])")
            if text.bound is not None:
                self.lines.append(f"if len({units}) > {text.bound * UNIT_BYTES}: raise overrun")
            self.pieces.add_expression(f"pack(len({units}) // {UNIT_BYTES})")
            self.pieces.add_expression(units)
            target.move(self.line("c", f"{target.text(4)} + len({units})"), UNIT_BYTES)
            offset.move(end)
        else:
            end = self.line("o", f"{start} + {count} * {UNIT_BYTES}")
            narrow = self.line("w", f"narrow(b[{start}:{end}])")
            self.pieces.add_expression(f"pack(len({narrow}))")
            self.pieces.add_expression(narrow)
            offset.move(end, UNIT_BYTES)

    def _convert_array(self, array: Array) -> None:
        element = array.element
        if array.length is not None:
            if array.length and isinstance(element, Plain):
                self._translate(element, array.length)
            elif array.length:
                self._loop(element, str(array.length))
            return
        self.align_source(4)
        self._align_target(4)
        start = self.source_at.text()
        count = self.read_count(array.bound if self.to_cdr else None)
        self.pieces.add_slice(start, self.source_at.text())
        self.target_at.advance(4)
        block = element.block
        if block is not None:
            self._copy_elements(count, block.size_bytes, block.alignment)
        elif isinstance(element, Plain):
            assert element.translation is not None
            start = self.source_at.text()
            end = self.line("o", f"{start} + {count}")
            self.pieces.add_expression(
                f"b[{start}:{end}].translate({self.functions.table(element.translation)})"
            )
            self.source_at.move(end)
            self.target_at.move(f"{self.target_at.text()} + {count}")
        else:
            self.limit(element, count)
            self._loop(element, count)

    def _copy_elements(self, count: str, size: int, alignment: int) -> None:
        """Copy a sequence of blocks, with padding before the first; an empty sequence has no padding."""
        self.align_if(self.source_at, count, alignment)
        if self.target_at.padding(alignment) != 0:
            before = self.line("c", self.target_at.text())
            self.target_at.move(before, 8)
            self.pieces.add_expression(f"pad{alignment}[{before} & {alignment - 1}] if {count} else b''")
            self.align_if(self.target_at, count, alignment)
        length = f"{count} * {size}" if size > 1 else count
        start = self.source_at.text()
        end = self.line("o", f"{start} + {length}")
        self.source_at.move(end, size)
        self.pieces.add_slice(start, end)
        self.target_at.move(f"{self.target_at.text()} + {length}", size)

    def _loop(self, element: Node, count: str) -> None:
        self.flush()
        before, after = self.variable("o"), self.variable("c")
        self.lines.append(f"{before} = {self.source_at.text()}")
        if self.to_cdr:
            self.lines.append(f"{after} = {self.target_at.text()}")
        if self._loops >= _MAX_LOOPS or self.is_long_with(element):
            if not self.to_cdr:
                self.lines.append(f"{after} = 0")
            name = self.functions.converter(element)
            self.lines.append(
                f"for _ in range({count}): {before}, {after} = {name}(b, {before}, {after}, out)"
            )
            self.source_at.move(before)
            self.target_at.move(after)
            return
        body, modulus, residue = self._loop_body(element, before, after)
        body.flush()
        body.lines.append(f"{before} = {body.source_at.text()}")
        if self.to_cdr:
            body.lines.append(f"{after} = {body.target_at.text()}")
        self.lines += [f"for _ in range({count}):", *indented(body.lines, 4)]
        self.continue_count(body)
        self.source_at = self._offset(before, modulus, residue, is_aligned=not self.to_cdr)
        self.target_at = self._offset(after, modulus, residue, is_aligned=self.to_cdr)

    def _loop_body(self, element: Node, before: str, after: str) -> tuple[ConvertingBody, int, int]:
        """Return the code that converts one element, with a modulus and a residue of the offsets in CDR.

        Every element begins at an offset with this residue. The end of an element is the beginning of the
        next one: a larger modulus for the beginning may give a larger one for the end. So this is repeated
        until the modulus stops growing.
        """
        start = self.target_at if self.to_cdr else self.source_at
        modulus, residue = 1, 0
        while True:
            body = ConvertingBody(
                self.functions,
                self.side,
                self._offset(before, modulus, residue, is_aligned=not self.to_cdr),
                self._offset(after, modulus, residue, is_aligned=self.to_cdr),
                loops=self._loops + 1,
            )
            body.continue_count(self)
            body.convert_inline(element)
            end = body.target_at if self.to_cdr else body.source_at
            shared = gcd(start.modulus, end.modulus)
            while (start.residue - end.residue) % shared:
                shared //= 2
            if shared <= modulus:
                return body, modulus, residue
            modulus, residue = shared, start.residue % shared

    @staticmethod
    def _offset(start: str, modulus: int, residue: int, *, is_aligned: bool) -> Offset:
        return Offset(start, 0, is_aligned=is_aligned, modulus=modulus, residue=residue)

    def _call_converter(self, name: str) -> None:
        self.flush()
        end, target_end = self.variable("o"), self.variable("c")
        target = self.target_at.text() if self.to_cdr else "0"
        self.lines.append(f"{end}, {target_end} = {name}(b, {self.source_at.text()}, {target}, out)")
        self.source_at.move(end)
        self.target_at.move(target_end)

    def _align_target(self, alignment: int) -> None:
        offset = self.target_at
        padding = offset.padding(alignment)
        if padding is not None:
            self.pieces.add_constant(bytes(padding))
            offset.advance(padding)
            return
        pads = "nul" if self.pieces.remove_final_nul() else "pad"
        self.pieces.add_expression(f"{pads}{alignment}[{offset.text()} & {alignment - 1}]")
        self.lines.append(offset.align(self.variable("c"), alignment))


def row(pieces: list[str]) -> str:
    """Return the source of a tuple of expressions, without its parentheses."""
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
