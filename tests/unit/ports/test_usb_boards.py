from __future__ import annotations

import pytest

from rostether.ports.usb_boards import UsbKind, board_of, usb_kind


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


@pytest.mark.parametrize(
    ("usb_id", "kind"),
    [
        ((0x2341, 0x0043), UsbKind.BOARD),
        ((0x2341, 0x0036), UsbKind.UNKNOWN),
        ((0x1A86, 0x7523), UsbKind.LIKELY_BOARD),
        ((0x067B, 0x2303), UsbKind.UNKNOWN),
        ((0x1546, 0x01A8), UsbKind.UNKNOWN),
        ((None, None), UsbKind.UNKNOWN),
    ],
)
def test_usb_kind(usb_id: tuple[int | None, int | None], kind: UsbKind) -> None:
    assert usb_kind(*usb_id) is kind
