"""Addresses of XBee radios: 16 bits that the user chooses (MY), or the 64 bits on the radio's label (SH, SL).

Both are whole numbers here. A number above 16 bits is a 64-bit address: those of Digi begin with 0013A2.
"""

from __future__ import annotations

import re

# 0xfffe means "use the 64-bit address".
MAX_SHORT_ADDRESS = 0xFFFD
# All radios, including those with 64-bit addresses.
BROADCAST_ADDRESS = 0xFFFF
_MAX_LONG_ADDRESS = 2**64 - 1

_LABEL = re.compile(r"(?:0x)?([0-9a-f]{16})", re.IGNORECASE)


def is_long(address: int) -> bool:
    """Return whether it is a 64-bit address."""
    return address > BROADCAST_ADDRESS


def is_of_one_radio(address: int) -> bool:
    """Return whether it is the address of one radio, not of all or of none."""
    return 0 <= address <= MAX_SHORT_ADDRESS or BROADCAST_ADDRESS < address < _MAX_LONG_ADDRESS


def parse_radio_address(text: str) -> int | None:
    """Return an address, None if the text is not one.

    16 bits are decimal or 0x...; 64 bits are the 16 hexadecimal digits of a label.
    """
    if label := _LABEL.fullmatch(text.replace(" ", "")):
        address = int(label[1], 16)
        return address if is_long(address) and is_of_one_radio(address) else None
    try:
        address = int(text, 0) if len(text) <= len("0xffff") else -1
    except ValueError:
        return None
    return address if 0 <= address <= MAX_SHORT_ADDRESS else None


def show_radio_address(address: int) -> str:
    """Return an address as labels and documents write it: 0x002a, 0013a20040a1b2c3."""
    return f"{address:016x}" if is_long(address) else f"{address:#06x}"
