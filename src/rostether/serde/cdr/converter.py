"""Converters between a message's ROS 1 serialization and CDR, compiled once for each pair of types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from rostether.errors import SerializationError
from rostether.mechanisms.text import counted
from rostether.msgdef.ros2.spec import Ros2Message
from rostether.serde.cdr.conversion_tree import Array, Node, Plain, Record, Side, Text
from rostether.serde.cdr.converter_source import ERRORS, LITTLE_ENDIAN, compile_conversion
from rostether.serde.cdr.field_matching import Lookup, match_fields
from rostether.serde.cdr.offset import UNIT_BYTES, widen
from rostether.serde.type_tree import MAX_EMPTY_ELEMENTS, Struct

_BIG_ENDIAN = b"\0\0"

ENCAPSULATION_BYTES: Final = 4


class CdrConverter:
    """Converts payloads of one pair of types, both ways.

    CDR is the format of ROS 2's middlewares: four bytes of encapsulation, then XCDR version 1. It is written
    in little endian, and read in both byte orders; bytes after the message are padding and ignored. Fields
    that only ROS 1 has are dropped in CDR, and zero in ROS 1. Fields that only ROS 2 has get the definition's
    default, or zero.
    """

    __slots__ = ("_tree", "from_cdr", "ros1_name", "ros2_name", "to_cdr")

    # Convert ROS 1 serialization to CDR. Raises SerializationError.
    to_cdr: Callable[[bytes], bytes]

    # Convert CDR to ROS 1 serialization. Raises SerializationError.
    from_cdr: Callable[[bytes], bytes]

    def __init__(self, tree: Record, ros1_name: str, ros2_name: str) -> None:
        self.ros1_name = ros1_name
        self.ros2_name = ros2_name
        self._tree = tree
        self.to_cdr = compile_conversion(tree, Side.ROS2, self._refuse_ros1)
        self.from_cdr = compile_conversion(tree, Side.ROS1, self._other_cdr)

    def to_cdr_all(self, payloads: Sequence[bytes]) -> list[bytes]:
        """Convert a batch. Raises SerializationError for the first that does not fit."""
        return list(map(self.to_cdr, payloads))

    def _refuse_ros1(self, payload: bytes) -> bytes:
        walker = PayloadWalker(payload, Side.ROS1)
        try:
            walker.over(self._tree)
        except Misfit as reason:
            raise SerializationError(
                f"{self.ros1_name}: the payload of {counted(len(payload), 'byte')} {reason}"
            ) from None
        raise SerializationError(
            f"the payload has {counted(len(payload) - walker.at, 'byte')} more than {self.ros1_name}"
        )

    def _other_cdr(self, cdr: bytes) -> bytes:
        """Convert big-endian CDR; raise SerializationError with the reason for other data."""
        if len(cdr) < len(LITTLE_ENDIAN):
            raise SerializationError(
                f"a payload of {counted(len(cdr), 'byte')} is not CDR, which starts with a header of 4 bytes"
            )
        if cdr[:2] not in (_BIG_ENDIAN, LITTLE_ENDIAN[:2]):
            raise SerializationError(
                f"the payload starts with {cdr[:2].hex(' ')}, but ROS 2 sends plain CDR: 00 01 or 00 00"
            )
        is_big_endian = cdr[:2] == _BIG_ENDIAN
        walker = PayloadWalker(cdr, Side.ROS2, is_big_endian=is_big_endian)
        try:
            if not self._tree.is_empty_in_ros2:
                walker.over(self._tree)
        except (Misfit, *ERRORS) as reason:
            raise SerializationError(
                f"{self.ros2_name}: the CDR of {counted(len(cdr), 'byte')} {reason}"
            ) from None
        if not is_big_endian:
            raise SerializationError(f"{self.ros2_name}: the CDR of {counted(len(cdr), 'byte')} does not fit")
        return self.from_cdr(LITTLE_ENDIAN + bytes(walker.payload[len(LITTLE_ENDIAN) :]))


def compile_message(ros1: Struct, ros2: Ros2Message, lookup: Lookup) -> CdrConverter:
    """Return the converter of a pair of types; `lookup` returns nested ROS 2 messages by `package/msg/Name`.

    Raises TypeMismatchError if their fields do not fit, and the errors of `lookup`.
    """
    return CdrConverter(match_fields(ros1, ros2, lookup), ros1.name, ros2.full_name)


class Misfit(Exception):  # noqa: N818
    """Ends a walk; the text is the reason, after "the payload of N bytes"."""


class PayloadWalker:
    """Walks over a payload field by field; `at` is its position in bytes.

    With `is_big_endian`, the payload is big-endian CDR, and the walk changes every number to little endian.
    """

    def __init__(self, payload: bytes, side: Side, *, is_big_endian: bool = False) -> None:
        self.payload = bytearray(payload)
        self.at = ENCAPSULATION_BYTES if side is Side.ROS2 else 0
        self._side = side
        self._is_big_endian = is_big_endian

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
            if count > MAX_EMPTY_ELEMENTS and array.element.min_bytes(Side.ROS1) == 0:
                limit = f"more than the limit of {MAX_EMPTY_ELEMENTS}"
                raise Misfit(f"announces {count} elements in field '{path}', {limit}")
            if count * array.element.min_bytes(self._side) > len(self.payload) - self.at:
                announced = f"announces {counted(count, 'element')} in field '{path}'"
                raise Misfit(f"{announced}, more than there are bytes for")
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
        if self._is_big_endian:
            for at in range(start, self.at, alignment):
                self.payload[at : at + alignment] = self.payload[at : at + alignment][::-1]

    def _skip(self, size: int, path: str) -> None:
        missing = self.at + size - len(self.payload)
        if missing > 0:
            raise Misfit(f"ends {counted(missing, 'byte')} early in field '{path}'")
        self.at += size
