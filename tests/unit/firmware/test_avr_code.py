from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.firmware.avr_code import Instruction, Op, decode
from rostether.firmware.avr_pointers import table_of_jump

# A `switch` on an Uno: subi r24, 0x67; sbci r25, 0xFE; movw r30, r24; jmp. The word address is 0x199.
AVR_GCC_16 = "87569e4ffc010c949101"
# movw r30, r24; subi r30, 0xCB; sbci r31, 0xFF; jmp. The word address is 0x35.
AVR_GCC_5 = "fc01eb5cff4f0c949101"


@pytest.mark.parametrize(
    ("words", "instruction"),
    [
        ([0x93CF], Instruction(Op.PUSH)),  # push r28
        ([0x91CF], Instruction(Op.POP)),  # pop r28
        ([0x940E, 0x0100], Instruction(Op.CALL, 4, 0x200)),  # call 0x200
        ([0x940F, 0x0100], Instruction(Op.CALL, 4, 0x20200)),  # call beyond 128 KiB
        ([0x940C, 0x0034], Instruction(Op.JUMP, 4, 0x68)),  # jmp 0x68
        ([0xD000], Instruction(Op.CALL, 2, 2)),  # rcall .+0
        ([0xDFFF], Instruction(Op.CALL, 2, 0)),  # rcall .-2
        ([0xC001], Instruction(Op.JUMP, 2, 4)),  # rjmp .+2
        ([0xF009], Instruction(Op.BRANCH, 2, 4)),  # breq .+2
        ([0xF7F9], Instruction(Op.BRANCH, 2, 0)),  # brne .-2
        ([0x1301], Instruction(Op.SKIP)),  # cpse r16, r17
        ([0xFD07], Instruction(Op.SKIP)),  # sbrc r16, 7
        ([0xFF07], Instruction(Op.SKIP)),  # sbrs r16, 7
        ([0x9928], Instruction(Op.SKIP)),  # sbic 0x05, 0
        ([0x9B28], Instruction(Op.SKIP)),  # sbis 0x05, 0
        ([0x9509], Instruction(Op.INDIRECT_CALL)),
        ([0x9519], Instruction(Op.INDIRECT_CALL)),
        ([0x9508], Instruction(Op.RETURN)),
        ([0x9518], Instruction(Op.RETURN)),
        ([0x9478], Instruction(Op.ENABLE_INTERRUPTS)),
        ([0xB7CD], Instruction(Op.READ_STACK_POINTER)),  # in r28, 0x3d
        ([0xBFCD], Instruction(Op.WRITE_STACK_POINTER, register=28)),  # out 0x3d, r28
        ([0xBF4D], Instruction(Op.WRITE_STACK_POINTER, register=20)),  # out 0x3d, r20
        ([0x972A], Instruction(Op.MOVE_FRAME, value=-10)),  # sbiw r28, 10
        ([0x962A], Instruction(Op.MOVE_FRAME, value=10)),  # adiw r28, 10
        ([0x52CC], Instruction(Op.MOVE_FRAME, value=-0x2C)),  # subi r28, 0x2c
        ([0x40D1], Instruction(Op.MOVE_FRAME_HIGH, value=-1)),  # sbci r29, 1
        ([0xE2AC], Instruction(Op.LOAD, value=0x2C, register=26)),  # ldi r26, 0x2c
        ([0x9180, 0x0100], Instruction(Op.OTHER, 4)),  # lds r24, 0x0100
        ([0x9380, 0x0100], Instruction(Op.OTHER, 4)),  # sts 0x0100, r24
        ([0x0000], Instruction(Op.OTHER)),
    ],
)
def test_instructions(words: list[int], instruction: Instruction) -> None:
    assert decode(b"".join(word.to_bytes(2, "little") for word in words), 0) == instruction


@given(st.binary(max_size=8), st.integers(0, 10))
def test_any_bytes_can_be_decoded(code: bytes, address: int) -> None:
    assert decode(code, address).size in (2, 4)


@pytest.mark.parametrize(("code", "table"), [(AVR_GCC_16, 0x332), (AVR_GCC_5, 0x6A)])
def test_the_table_of_a_switch_is_found(code: str, table: int) -> None:
    assert table_of_jump(bytes.fromhex(code), 6) == table


def test_a_jump_without_a_table_has_none() -> None:
    assert table_of_jump(bytes.fromhex("0000" * 3 + "0c949101"), 6) is None
