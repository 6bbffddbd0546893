"""Decodes AVR machine code: the instructions that move the stack pointer or change the control flow.

Source: the AVR Instruction Set Manual.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto


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


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction. `target` is a byte address, `value` is added to or loaded into `register`."""

    op: Op
    size: int = 2
    target: int = 0
    value: int = 0
    register: int = 0


_FIXED = {
    0x9508: Op.RETURN,
    0x9518: Op.RETURN,
    0x9509: Op.INDIRECT_CALL,
    0x9519: Op.INDIRECT_CALL,
    0x9409: Op.INDIRECT_JUMP,
    0x9419: Op.INDIRECT_JUMP,
    0x9478: Op.ENABLE_INTERRUPTS,
    # The low byte (r28) is read first and written last.
    0xB7CD: Op.READ_STACK_POINTER,
}
_OTHER = Instruction(Op.OTHER)
_OTHER_LONG = Instruction(Op.OTHER, 4)
_SKIP = Instruction(Op.SKIP)


def decode(code: bytes, address: int) -> Instruction:  # noqa: C901, PLR0911, PLR0912 - one branch for each form of instruction
    """Return the instruction at a byte address; beyond the end of the code everything is OTHER."""
    word = int.from_bytes(code[address : address + 2], "little")
    op = _FIXED.get(word)
    if op is not None:
        return Instruction(op)
    if word & 0xFC0F == 0x9000:  # lds, sts
        return _OTHER_LONG
    if word & 0xFE0F == 0xBE0D:  # out 0x3d
        return Instruction(Op.WRITE_STACK_POINTER, register=word >> 4 & 0x1F)
    if word & 0xFE0F == 0x920F:
        return Instruction(Op.PUSH)
    if word & 0xFE0F == 0x900F:
        return Instruction(Op.POP)
    if word & 0xFE0C == 0x940C:
        high = (word >> 3 & 0x3E) | (word & 1)
        target = (high << 16 | int.from_bytes(code[address + 2 : address + 4], "little")) * 2
        return Instruction(Op.CALL if word & 2 else Op.JUMP, 4, target)
    if word & 0xE000 == 0xC000:
        target = address + 2 + 2 * _signed(word & 0xFFF, 12)
        return Instruction(Op.CALL if word & 0x1000 else Op.JUMP, 2, target)
    if word & 0xF800 == 0xF000:
        return Instruction(Op.BRANCH, 2, address + 2 + 2 * _signed(word >> 3 & 0x7F, 7))
    if word & 0xFC00 == 0x1000 or word & 0xFC08 == 0xFC00 or word & 0xFD00 == 0x9900:
        return _SKIP
    if word & 0xFE30 == 0x9620:  # adiw, sbiw on r28
        amount = (word >> 2 & 0x30) | (word & 0xF)
        return Instruction(Op.MOVE_FRAME, value=-amount if word & 0x100 else amount)
    if word & 0xF0F0 == 0x50C0:  # subi r28
        return Instruction(Op.MOVE_FRAME, value=-immediate(word))
    if word & 0xF0F0 == 0x40D0:  # sbci r29
        return Instruction(Op.MOVE_FRAME_HIGH, value=-immediate(word))
    if word & 0xF000 == 0xE000:
        return Instruction(Op.LOAD, value=immediate(word), register=16 + (word >> 4 & 0xF))
    return _OTHER


def immediate(word: int) -> int:
    """Return the eight-bit constant in an instruction such as ldi or subi."""
    return (word >> 4 & 0xF0) | (word & 0xF)


def _signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value
