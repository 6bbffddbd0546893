"""Decodes AVR machine code: instructions that move the stack pointer or change the control flow; pointers.

A virtual call loads the table's address from the object, then the function's address from the table. A plain
pointer is loaded once. The last two loads of r30 before the call show which kind it is.
Source: the AVR Instruction Set Manual.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto
from functools import cache
from typing import TypeAlias

from msgspec import Struct

PLAIN = -1
UNKNOWN = -2

# The largest number of instructions between loading a pointer and the call: they load the arguments.
_MAX_DISTANCE = 24

# The same between computing a table's address and the jump.
_MAX_TABLE_DISTANCE = 8

_MOVE_FROM_R0 = 0x2DE0
_LOAD_R0_FROM_Z = 0x9001
_LOADS_OF_R30_FROM_X = (0x91ED, 0x91EC)
_TABLE_HEADER_BYTES = 4


class Op(Enum):
    """The effect of an instruction on the stack or on the control flow."""

    OTHER = auto()
    PUSH = auto()
    POP = auto()
    CALL = auto()
    JUMP = auto()
    BRANCH = auto()
    SKIP = auto()
    INDIRECT_CALL = auto()
    INDIRECT_JUMP = auto()
    RETURN = auto()
    ENABLE_INTERRUPTS = auto()
    READ_STACK_POINTER = auto()
    WRITE_STACK_POINTER = auto()
    MOVE_FRAME = auto()
    MOVE_FRAME_HIGH = auto()
    LOAD = auto()


class Instruction(Struct, frozen=True):
    """One instruction. `target` is a byte address, `value` is added to or loaded into `register`."""

    op: Op
    size: int = 2
    target: int = 0
    value: int = 0
    register: int = 0


def decode(code: bytes, address: int) -> Instruction:
    """Return the instruction at a byte address; beyond the end of the code everything is OTHER."""
    word = int.from_bytes(code[address : address + 2], "little")
    return _reader(word)(word, code, address)


def _immediate(word: int) -> int:
    """Return the eight-bit constant in an instruction such as ldi or subi."""
    return (word >> 4 & 0xF0) | (word & 0xF)


def _signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value


def _jump_or_call(word: int, code: bytes, address: int) -> Instruction:
    high = (word >> 3 & 0x3E) | (word & 1)
    target = (high << 16 | int.from_bytes(code[address + 2 : address + 4], "little")) * 2
    return Instruction(Op.CALL if word & 2 else Op.JUMP, 4, target)


def _relative_jump_or_call(word: int, _code: bytes, address: int) -> Instruction:
    target = address + 2 + 2 * _signed(word & 0xFFF, 12)
    return Instruction(Op.CALL if word & 0x1000 else Op.JUMP, 2, target)


def _branch(word: int, _code: bytes, address: int) -> Instruction:
    return Instruction(Op.BRANCH, 2, address + 2 + 2 * _signed(word >> 3 & 0x7F, 7))


def _move_frame(word: int, _code: bytes, _address: int) -> Instruction:
    amount = (word >> 2 & 0x30) | (word & 0xF)
    return Instruction(Op.MOVE_FRAME, value=-amount if word & 0x100 else amount)


def _subtract_from_frame(word: int, _code: bytes, _address: int) -> Instruction:
    return Instruction(Op.MOVE_FRAME if word & 0x1000 else Op.MOVE_FRAME_HIGH, value=-_immediate(word))


def _load(word: int, _code: bytes, _address: int) -> Instruction:
    return Instruction(Op.LOAD, value=_immediate(word), register=16 + (word >> 4 & 0xF))


def _write_stack_pointer(word: int, _code: bytes, _address: int) -> Instruction:
    return Instruction(Op.WRITE_STACK_POINTER, register=word >> 4 & 0x1F)


def _always(op: Op, size: int = 2) -> _Read:
    instruction = Instruction(op, size)
    return lambda _word, _code, _address: instruction


_Read: TypeAlias = Callable[[int, bytes, int], Instruction]

# The bits that identify an instruction: mask, value, and how to read the rest of it.
_FORMS: tuple[tuple[int, int, _Read], ...] = (
    (0xFFEF, 0x9508, _always(Op.RETURN)),
    (0xFFEF, 0x9509, _always(Op.INDIRECT_CALL)),
    (0xFFEF, 0x9409, _always(Op.INDIRECT_JUMP)),
    (0xFFFF, 0x9478, _always(Op.ENABLE_INTERRUPTS)),
    # The low byte (r28) is read first and written last.
    (0xFFFF, 0xB7CD, _always(Op.READ_STACK_POINTER)),
    (0xFE0F, 0xBE0D, _write_stack_pointer),  # out 0x3d
    (0xFC0F, 0x9000, _always(Op.OTHER, 4)),  # lds, sts
    (0xFE0F, 0x920F, _always(Op.PUSH)),
    (0xFE0F, 0x900F, _always(Op.POP)),
    (0xFE0C, 0x940C, _jump_or_call),
    (0xE000, 0xC000, _relative_jump_or_call),
    (0xF800, 0xF000, _branch),
    (0xFC00, 0x1000, _always(Op.SKIP)),  # cpse
    (0xFC08, 0xFC00, _always(Op.SKIP)),  # sbrc, sbrs
    (0xFD00, 0x9900, _always(Op.SKIP)),  # sbic, sbis
    (0xFE30, 0x9620, _move_frame),  # adiw, sbiw on r28
    (0xF0F0, 0x50C0, _subtract_from_frame),  # subi r28
    (0xF0F0, 0x40D0, _subtract_from_frame),  # sbci r29
    (0xF000, 0xE000, _load),
    (0x0000, 0x0000, _always(Op.OTHER)),
)


@cache
def _reader(word: int) -> _Read:
    return next(read for mask, value, read in _FORMS if word & mask == value)


def pointer_kind(flash: bytes, call: int) -> int:
    """Return the offset of the slot that the call at an address uses, PLAIN, or UNKNOWN."""
    slot: int | None = None
    address = call
    for _ in range(_MAX_DISTANCE):
        address -= 2
        if address < 0:
            break
        word = int.from_bytes(flash[address : address + 2], "little")
        if _loads_r30(word):
            return PLAIN if slot is None else slot
        if word == _MOVE_FROM_R0:
            if slot is not None:
                return slot
            slot = _slot_before(flash, address)
            if slot is None:
                return UNKNOWN
        elif word & 0xFFF0 == 0x01F0 or word & 0xF0F0 == 0xE0E0:  # movw r30, ldi r30
            # The address of the object itself: the value loaded from it is a plain pointer.
            return UNKNOWN if slot is None else PLAIN
    return UNKNOWN


def table_of_jump(flash: bytes, jump: int) -> int | None:
    """Return the address of the table that a large `switch` uses at a jump, None if it is not found."""
    for address in range(jump - 4, max(jump - 2 * _MAX_TABLE_DISTANCE, -2), -2):
        low = int.from_bytes(flash[address : address + 2], "little")
        high = int.from_bytes(flash[address + 2 : address + 4], "little")
        # subi and sbci of two neighboring registers subtract the complement of the table's word address.
        is_pair = low & 0xF000 == 0x5000 and high & 0xF000 == 0x4000
        if is_pair and (high >> 4) & 0xF == ((low >> 4) + 1) & 0xF:
            return 2 * (-(_immediate(high) << 8 | _immediate(low)) & 0xFFFF)
    return None


def table_functions(table: bytes) -> dict[int, int]:
    """Return the slots of a virtual table: offset -> word address of a function."""
    return {
        offset - _TABLE_HEADER_BYTES: int.from_bytes(table[offset : offset + 2], "little")
        for offset in range(_TABLE_HEADER_BYTES, len(table) - 1, 2)
    }


def _loads_r30(word: int) -> bool:
    through_y = word & 0xD208 == 0x8008 and word >> 4 & 0x1F == 30
    through_z = word & 0xD208 == 0x8000 and word >> 4 & 0x1F == 30
    return word in _LOADS_OF_R30_FROM_X or through_y or through_z


def _slot_before(flash: bytes, address: int) -> int | None:
    """Return the offset from Z of the preceding load of r0."""
    for back in (2, 4, 6):
        word = int.from_bytes(flash[address - back : address - back + 2], "little")
        if word == _LOAD_R0_FROM_Z:
            return 0
        if word & 0xD208 == 0x8000 and word >> 4 & 0x1F == 0:
            return (word >> 8 & 0x20) | (word >> 7 & 0x18) | (word & 7)
    return None
