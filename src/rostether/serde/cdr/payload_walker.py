"""A slow walk over one payload: it finds what does not fit and where, and swaps big-endian CDR."""

from __future__ import annotations

from typing import Final

from rostether.serde.cdr.conversion_tree import Array, Node, Plain, Record, Side, Text
from rostether.serde.cdr.wide_text import UNIT_BYTES, widen
from rostether.serde.type_tree import MAX_EMPTY_ELEMENTS

ENCAPSULATION_BYTES: Final = 4


class Misfit(Exception):  # noqa: N818
    """Ends a walk; the text is the reason, to follow "the payload of N bytes"."""


class PayloadWalker:
    """Walks over a payload field by field; `at` is where it is, in bytes.

    With `turned`, the payload is big-endian CDR, and every number walked over becomes little-endian there.
    """

    def __init__(self, payload: bytes, side: Side, *, turned: bool = False) -> None:
        self.payload = bytearray(payload)
        self.at = ENCAPSULATION_BYTES if side is Side.ROS2 else 0
        self._side = side
        self._turned = turned

    def over(self, node: Node, path: str = "") -> None:
        """Walk over one value. Raises Misfit."""
        if isinstance(node, Plain):
            self._number(node.size_bytes, node.alignment, path)
        elif isinstance(node, Text):
            self._over_text(node, path)
        elif isinstance(node, Array):
            self._over_array(node, path)
        else:
            self._over_record(node, path)

    def _over_text(self, text: Text, path: str) -> None:
        count = self._count(path)
        if text.is_wide and self._side is Side.ROS2:
            self._skip(count * UNIT_BYTES, path)
            self.at -= count * UNIT_BYTES
            for _ in range(count):
                self._number(UNIT_BYTES, UNIT_BYTES, path)
            return
        self._skip(count, path)
        if text.is_wide:
            units = widen(bytes(self.payload[self.at - count : self.at]))
            self._require_bound(len(units) // UNIT_BYTES, text.bound, "UTF-16 units", path)
        else:
            # ROS 2 counts the NUL at a string's end.
            self._require_bound(count, text.bound, "bytes", path)

    def _over_record(self, record: Record, path: str) -> None:
        for slot in record.slots(self._side):
            name = slot.ros1_name if self._side is Side.ROS1 else slot.ros2_name
            self.over(slot.node, f"{path}.{name}" if path else name)

    def _over_array(self, array: Array, path: str) -> None:
        count = array.length
        if count is None:
            count = self._count(path)
            self._require_bound(count, array.bound, "elements", path)
            if count > MAX_EMPTY_ELEMENTS and array.element.least_bytes(Side.ROS1) == 0:
                raise Misfit(f"announces {count} elements in field '{path}', over the limit")
            if count * array.element.least_bytes(self._side) > len(self.payload) - self.at:
                raise Misfit(f"announces {count} elements in field '{path}', more than there are bytes for")
        for index in range(count):
            self.over(array.element, f"{path}[{index}]")

    def _require_bound(self, count: int, bound: int | None, noun: str, path: str) -> None:
        if bound is not None and count > bound and self._side is Side.ROS1:
            raise Misfit(f"has {count} {noun} in field '{path}', but ROS 2 allows at most {bound}")

    def _count(self, path: str) -> int:
        self._number(4, 4, path)
        return int.from_bytes(self.payload[self.at - 4 : self.at], "little")

    def _number(self, size: int, alignment: int, path: str) -> None:
        if self._side is Side.ROS2:
            self.at += (ENCAPSULATION_BYTES - self.at) % alignment
        start = self.at
        self._skip(size, path)
        if self._turned:
            for at in range(start, self.at, alignment):
                self.payload[at : at + alignment] = self.payload[at : at + alignment][::-1]

    def _skip(self, size: int, path: str) -> None:
        missing = self.at + size - len(self.payload)
        if missing > 0:
            raise Misfit(f"ends {missing} {'byte' if missing == 1 else 'bytes'} early in field '{path}'")
        self.at += size
