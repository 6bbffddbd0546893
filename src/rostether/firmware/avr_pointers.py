"""Determines the kind of pointer in an AVR call: a slot of a virtual table, or a plain function pointer.

A virtual call loads the table's address from the object, then the function's address from the table. A plain
pointer is loaded once. The last two loads of r30 before the call show which kind it is.
"""

from __future__ import annotations

from rostether.firmware.avr_code import immediate

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
            return 2 * (-(immediate(high) << 8 | immediate(low)) & 0xFFFF)
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
