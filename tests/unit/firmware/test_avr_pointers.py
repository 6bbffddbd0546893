from __future__ import annotations

import pytest

from rostether.firmware.avr_pointers import table_of_jump

# A `switch` on an Uno: subi r24, 0x67; sbci r25, 0xFE; movw r30, r24; jmp. The word address is 0x199.
AVR_GCC_16 = "87569e4ffc010c949101"
# movw r30, r24; subi r30, 0xCB; sbci r31, 0xFF; jmp. The word address is 0x35.
AVR_GCC_5 = "fc01eb5cff4f0c949101"


@pytest.mark.parametrize(("code", "table"), [(AVR_GCC_16, 0x332), (AVR_GCC_5, 0x6A)])
def test_the_table_of_a_switch_is_found(code: str, table: int) -> None:
    assert table_of_jump(bytes.fromhex(code), 6) == table


def test_a_jump_without_a_table_has_none() -> None:
    assert table_of_jump(bytes.fromhex("0000" * 3 + "0c949101"), 6) is None
