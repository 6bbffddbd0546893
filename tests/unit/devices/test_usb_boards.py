from __future__ import annotations

import pytest

from rostether.cli.usb_boards import board_of


@pytest.mark.parametrize(
    ("usb_id", "board"),
    [
        ((0x2341, 0x0043), "Arduino Uno"),
        ((0x2A03, 0x0243), "Arduino Uno"),
        ((0x2341, 0x8036), "Arduino Leonardo"),
        ((0x2341, 0xFFFF), "Arduino"),
        ((0x16C0, 0x0483), "Teensy"),
        ((0x16C0, 0x0484), ""),
        ((None, None), ""),
        ((0x2341, None), ""),
    ],
)
def test_board_of(usb_id: tuple[int | None, int | None], board: str) -> None:
    assert board_of(*usb_id) == board
