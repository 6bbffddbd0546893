"""Generated code that skips values of one side, such as fields that the other side does not have."""

from __future__ import annotations

from typing import Final, Protocol

from rostether.serde.cdr.conversion_tree import Array, Node, Plain, Record, Side, Text, Translation
from rostether.serde.cdr.offset import UNIT_BYTES, Offset
from rostether.serde.type_tree import MAX_EMPTY_ELEMENTS

# The limit of numbers, strings and arrays of inline records in one function; further records get separate
# functions. Otherwise, the source would grow exponentially if each type contains the next one twice.
MAX_PARTS: Final = 256


class Functions(Protocol):
    """The functions and names outside of a body."""

    def converter(self, node: Node) -> str:
        """Return the name of `convert_n(b, o, c, out) -> (o, c)`, the ends of its input and output."""

    def walker(self, node: Node) -> str:
        """Return the name of `walk_n(b, o) -> o`, which skips a value."""

    def table(self, translation: Translation) -> str:
        """Return the name of a translation's table."""

    def part_count(self, node: Node) -> int:
        """Return how many parts the inline conversion of a value needs."""


class ReadingBody:
    """The body of one function: lines that read lengths of the payload `b`, from a position on."""

    def __init__(self, functions: Functions, side: Side, source_at: Offset) -> None:
        self.functions = functions
        self.side = side
        self.to_cdr = side is Side.ROS1
        self.lines: list[str] = []
        self.source_at = source_at
        self.parts = 0
        self._count = 0

    def skip(self, node: Node) -> None:
        """Skip one value, in a separate function if this one has become long."""
        if isinstance(node, Record) and self.is_long_with(node):
            offset = self.source_at
            offset.move(self.line("o", f"{self.functions.walker(node)}(b, {offset.text()})"))
        else:
            self.skip_inline(node)

    def skip_inline(self, node: Node) -> None:
        """Skip one value in this function."""
        offset = self.source_at
        size = node.ros1_size_bytes if self.to_cdr else None
        self.parts += not isinstance(node, Record)
        if size is not None:
            offset.advance(size)
        elif node.block is not None or isinstance(node, Plain):
            block = node.block
            self.align_source(block.alignment if block else 1)
            offset.advance(block.size_bytes if block else 1)
        elif isinstance(node, Text):
            count = self.read_count(None)
            if node.is_wide and not self.to_cdr:
                offset.move(self.line("o", f"{offset.text()} + {count} * {UNIT_BYTES}"), UNIT_BYTES)
            else:
                offset.move(self.line("o", f"{offset.text()} + {count}"))
        elif isinstance(node, Array):
            self._skip_array(node)
        else:
            for slot in node.slots(self.side):
                self.skip(slot.node)

    def limit(self, element: Node, count: str) -> None:
        """Refuse counts of elements that exceed the remaining bytes."""
        min_bytes = element.min_bytes(self.side)
        if element.min_bytes(Side.ROS1) == 0:
            self.lines.append(f"if {count} > {MAX_EMPTY_ELEMENTS}: raise overrun")
        if min_bytes:
            self.lines.append(f"if {count} * {min_bytes} > len(b) - ({self.source_at.text()}): raise overrun")

    def _skip_array(self, array: Array) -> None:
        element, offset = array.element, self.source_at
        count = str(array.length)
        if array.length is None:
            count = self.read_count(None)
            size = element.ros1_size_bytes if self.to_cdr else None
            if size is not None:
                offset.move(self.line("o", f"{offset.text()} + {count} * {size}"))
                return
            block = element.block or (Plain(1, 1).block if isinstance(element, Plain) else None)
            if block is not None:
                self.align_if(offset, count, block.alignment)
                offset.move(
                    self.line("o", f"{offset.text()} + {count} * {block.size_bytes}"), block.size_bytes
                )
                return
            self.limit(element, count)
        elif isinstance(element, Plain):
            offset.advance(array.length)
            return
        name = self.functions.walker(element)
        variable = self.line("o", offset.text())
        self.lines.append(f"for _ in range({count}): {variable} = {name}(b, {variable})")
        offset.move(variable)

    def read_count(self, bound: int | None) -> str:
        """Read a length, and refuse one above its bound."""
        self.align_source(4)
        count = self.variable("n")
        self.lines.append(f"{count}, = u32(b, {self.source_at.text()})")
        if bound is not None:
            self.lines.append(f"if {count} > {bound}: raise overrun")
        self.source_at.advance(4)
        return count

    def align_source(self, alignment: int) -> None:
        """Go to the next aligned offset."""
        padding = self.source_at.padding(alignment)
        if padding is not None:
            self.source_at.advance(padding)
        else:
            self.lines.append(self.source_at.align(self.variable("o"), alignment))

    def align_if(self, offset: Offset, count: str, alignment: int) -> None:
        """Go to the first of `count` values: without values there is no padding."""
        if offset.padding(alignment) == 0:
            return
        # After the count, the position is a multiple of four; only values of eight bytes get here.
        before = offset.text()
        variable = self.variable("o")
        self.lines.append(f"{offset.align(variable, alignment)} if {count} else {before}")
        offset.modulus = min(alignment, 4)

    def line(self, prefix: str, expression: str) -> str:
        """Add a line that assigns an expression to a new variable; return the variable."""
        variable = self.variable(prefix)
        self.lines.append(f"{variable} = {expression}")
        return variable

    def continue_count(self, other: ReadingBody) -> None:
        """Continue the count of another body of the same function."""
        self.parts = other.parts
        self._count = other._count

    def is_long_with(self, node: Node) -> bool:
        """Return whether the function has become too long for another inline value."""
        return self.parts + self.functions.part_count(node) > MAX_PARTS

    def variable(self, prefix: str) -> str:
        """Return the name of a new variable."""
        self._count += 1
        return f"{prefix}{self._count - 1}"
