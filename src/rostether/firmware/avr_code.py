"""Decodes AVR machine code: the instructions that move the stack pointer or change the control flow.

Source: the AVR Instruction Set Manual.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto
from functools import cache
from typing import TypeAlias

from msgspec import Struct


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


def immediate(word: int) -> int:
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
    return Instruction(Op.MOVE_FRAME if word & 0x1000 else Op.MOVE_FRAME_HIGH, value=-immediate(word))


def _load(word: int, _code: bytes, _address: int) -> Instruction:
    return Instruction(Op.LOAD, value=immediate(word), register=16 + (word >> 4 & 0xF))


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
