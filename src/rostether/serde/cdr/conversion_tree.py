"""One ROS 1 type and one ROS 2 type with their fields matched: the input of a converter's compilation.

ROS 1 writes values without gaps. CDR (XCDR1, as in ROS 2's middlewares) aligns numbers of two, four and eight
bytes to their size, counted from the end of the four bytes of encapsulation. Structs are not aligned. So most
values have the same bytes on both sides, at other positions. Source: OMG DDS-XTypes 1.3, section 7.4.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Final, TypeAlias

from msgspec import Struct

# The only field, a uint8, of a ROS 2 message without fields, as in rosidl.
DUMMY_NAME: Final = "structure_needs_at_least_one_member"


class Side(Enum):
    """Which of the two definitions has a field."""

    BOTH = "both"
    ROS1 = "ROS 1"
    ROS2 = "ROS 2"


class Block(Struct, frozen=True):
    """Bytes that are equal on both sides, without padding inside once the first byte is aligned."""

    size_bytes: int
    alignment: int


class Translation(Struct, frozen=True):
    """Two tables of 256 bytes for `bytes.translate`."""

    to_ros2: bytes
    to_ros1: bytes


class Plain(Struct, frozen=True, eq=False):
    """A number, or a stamp (two numbers of four bytes).

    `translation` is given for numbers of one byte whose values differ between ROS 1 and ROS 2.
    """

    size_bytes: int
    alignment: int
    translation: Translation | None = None

    @property
    def block(self) -> Block | None:
        """The value as a block; None if it is translated."""
        return None if self.translation is not None else Block(self.size_bytes, self.alignment)

    @property
    def ros1_size_bytes(self) -> int:
        """The size in ROS 1."""
        return self.size_bytes

    def min_bytes(self, _side: Side) -> int:
        """Return the size."""
        return self.size_bytes


class Text(Struct, frozen=True, eq=False):
    """A string, or a wstring if `is_wide`: UTF-16 in ROS 2, UTF-8 in ROS 1.

    `bound` is the limit of bytes, or units of UTF-16, in ROS 2; None for any number.
    """

    bound: int | None = None
    is_wide: bool = False
    block: None = None
    ros1_size_bytes: None = None

    def min_bytes(self, _side: Side) -> int:
        """Return the size of the length field, the minimum."""
        return 4


@dataclass(frozen=True, slots=True, eq=False)
class Array:
    """An array of `length` elements; None means any length up to `bound`."""

    element: Plain | Text | Record
    length: int | None
    bound: int | None = None
    block: Block | None = field(init=False)
    ros1_size_bytes: int | None = field(init=False)

    def __post_init__(self) -> None:
        element = self.element.block
        block = None
        if element is not None and self.length:
            block = Block(self.length * element.size_bytes, element.alignment)
        object.__setattr__(self, "block", block)
        size = self.element.ros1_size_bytes
        if self.length is None or size is None:
            size = 0 if self.length == 0 else None
        else:
            size *= self.length
        object.__setattr__(self, "ros1_size_bytes", size)

    def min_bytes(self, side: Side) -> int:
        """Return the minimum size of an array on a side, without padding."""
        return 4 if self.length is None else self.length * self.element.min_bytes(side)


class Slot(Struct, frozen=True, eq=False):
    """One field of a record, under its name on each side ("" if it has none).

    `default` is the value of a field that only ROS 2 has: pieces of bytes with their alignment.
    """

    ros1_name: str
    ros2_name: str
    node: Node
    default: tuple[tuple[int, bytes], ...] = ()

    @property
    def side(self) -> Side:
        """The sides that have the field."""
        if not self.ros1_name:
            return Side.ROS2
        return Side.BOTH if self.ros2_name else Side.ROS1


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """A message: its slots in the order of ROS 1, and in the order of ROS 2."""

    name: str
    ros1_slots: tuple[Slot, ...]
    ros2_slots: tuple[Slot, ...]
    block: Block | None = field(init=False)

    # The size in bytes of every ROS 1 value, None if it varies.
    ros1_size_bytes: int | None = field(init=False)
    _min_bytes: tuple[int, int] = field(init=False)

    def __post_init__(self) -> None:
        # Computed once: if each type contains the next one twice, the number of paths grows exponentially.
        object.__setattr__(self, "block", _record_block(self))
        sizes = [slot.node.ros1_size_bytes for slot in self.ros1_slots]
        size = None if None in sizes else sum(size or 0 for size in sizes)
        object.__setattr__(self, "ros1_size_bytes", size)
        min_bytes = [
            sum(slot.node.min_bytes(side) for slot in self.slots(side)) for side in (Side.ROS1, Side.ROS2)
        ]
        object.__setattr__(self, "_min_bytes", tuple(min_bytes))

    def min_bytes(self, side: Side) -> int:
        """Return the minimum size of a message on a side, without padding."""
        return self._min_bytes[0 if side is Side.ROS1 else 1]

    @property
    def is_ordered(self) -> bool:
        """Whether the fields of both sides are in the same order."""
        shared = [slot for slot in self.ros1_slots if slot.side is Side.BOTH]
        return shared == [slot for slot in self.ros2_slots if slot.side is Side.BOTH]

    @property
    def is_empty_in_ros2(self) -> bool:
        """Whether the ROS 2 message has no fields, so that it has only the placeholder."""
        return [slot.ros2_name for slot in self.ros2_slots] == [DUMMY_NAME]

    def slots(self, side: Side) -> tuple[Slot, ...]:
        """Return the slots in the order of one side."""
        return self.ros1_slots if side is Side.ROS1 else self.ros2_slots


Node: TypeAlias = Plain | Text | Array | Record


def _record_block(record: Record) -> Block | None:
    if record.ros1_slots != record.ros2_slots or not record.ros1_slots:
        return None
    size = 0
    first = record.ros1_slots[0].node.block
    for slot in record.ros1_slots:
        block = slot.node.block
        # The alignments are valid at any position only if that of the first byte is the strictest.
        if first is None or block is None or block.alignment > first.alignment or size % block.alignment:
            return None
        size += block.size_bytes
    assert first is not None
    return None if size % first.alignment else Block(size, first.alignment)
