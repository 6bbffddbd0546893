"""The stack of single functions, from their machine code."""

from __future__ import annotations

import struct

from rostether.firmware.stack_walk import Code, walk


def test_the_frame_of_a_shared_prologue_is_that_of_its_own_function() -> None:
    words = (
        *(0xE4A0, 0x9508),  # another function: ldi r26, 0x40; ret
        *(0xE0A0, 0xE0B1),  # the function: a frame of 0x100 bytes in r26 and r27
        *(0xE0E7, 0xE0F0, 0xC003),  # ldi r30; ldi r31; rjmp __prologue_saves__
        *(0x9508, 0, 0),  # ret
        0x922F,  # __prologue_saves__: push r2
    )
    entries = {0: "other", 4: "function", 20: "__prologue_saves__"}
    code = Code(struct.pack(f"<{len(words)}H", *words), entries, {}, 0, return_bytes=2)
    assert walk(code, 4).depth_bytes == 18 + 0x100


def test_the_size_of_a_damaged_function_needs_no_memory() -> None:
    words = (0xE0E2, 0xE0F0, 0x9409, 0x9508)  # ldi r30, 2; ldi r31, 0; ijmp; ret
    code = Code(struct.pack("<4H", *words), {0: "function"}, {0: 1 << 50}, 1 << 50, return_bytes=2)
    assert code.labels(0, 4) == [2 * 0x9409, 2 * 0x9508, 2 * 0xE0E2, 2 * 0xE0F0]
