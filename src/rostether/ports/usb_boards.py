"""The boards and adapters with known USB ids; many describe themselves only as `USB Serial`.

Some ids belong only to boards. Some belong mostly to boards, so discovery listens before it probes. Others
belong to general-purpose adapters, which are opened only if the user allows it.

Source: the USB ids that vendors publish in their boards.txt, drivers and udev rules.
"""

from __future__ import annotations

from enum import Enum, auto

_ARDUINO = 0x2341
_ARDUINO_ORG = 0x2A03

# Product ids of both Arduino vendors.
_BOARDS = {
    0x0001: "Arduino Uno",
    0x0010: "Arduino Mega 2560",
    0x0036: "Arduino Leonardo, in its bootloader",
    0x0037: "Arduino Micro, in its bootloader",
    0x003D: "Arduino Due, programming port",
    0x003E: "Arduino Due, native port",
    0x003F: "Arduino Mega ADK",
    0x0042: "Arduino Mega 2560",
    0x0043: "Arduino Uno",
    0x0044: "Arduino Mega ADK",
    0x004D: "Arduino Zero, in its bootloader",
    0x0058: "Arduino Nano Every",
    0x0069: "Arduino Uno R4 Minima",
    0x0070: "Arduino Nano ESP32",
    0x1002: "Arduino Uno R4 WiFi",
    0x8036: "Arduino Leonardo",
    0x8037: "Arduino Micro",
    0x804D: "Arduino Zero",
    0x804E: "Arduino MKR1000",
    0x8054: "Arduino MKR WiFi 1010",
    0x8057: "Arduino Nano 33 IoT",
    0x805A: "Arduino Nano 33 BLE",
}

_OTHERS = {
    (0x0403, 0x6001): "FTDI FT232R adapter",
    (0x0403, 0x6010): "FTDI FT2232 adapter",
    (0x0403, 0x6014): "FTDI FT232H adapter",
    (0x0403, 0x6015): "FTDI FT231X adapter",
    (0x0483, 0x374B): "ST-Link of an STM32 Nucleo or Discovery board",
    (0x0483, 0x5740): "STM32 board (OpenCR and others)",
    (0x067B, 0x2303): "Prolific PL2303 adapter",
    (0x10C4, 0xEA60): "CP210x adapter (ESP32 and other boards)",
    (0x16C0, 0x0483): "Teensy",
    (0x1A86, 0x5523): "CH341 adapter (Arduino compatible and ESP boards)",
    (0x1A86, 0x55D4): "CH9102 adapter (ESP32 boards)",
    (0x1A86, 0x7523): "CH340 adapter (Arduino compatible and ESP boards)",
    (0x239A, 0x80F4): "Raspberry Pi Pico with CircuitPython",
    (0x2E8A, 0x0003): "Raspberry Pi Pico, in its bootloader",
    (0x2E8A, 0x000A): "Raspberry Pi Pico",
    (0x303A, 0x1001): "ESP32 with built-in USB",
    (0xFFF1, 0xFF48): "OpenCR",
}


# Chips of FTDI, Silicon Labs and WCH are on Nanos, RedBoards and ESP boards, but also in GPS receivers and
# lidars. Flight controllers and printers also use the id of ST's example. CircuitPython may show a prompt.
_LIKELY_BOARDS = frozenset(
    {
        (0x0403, 0x6001),
        (0x0403, 0x6015),
        (0x0483, 0x5740),
        (0x10C4, 0xEA60),
        (0x1A86, 0x5523),
        (0x1A86, 0x55D4),
        (0x1A86, 0x7523),
        (0x239A, 0x80F4),
    }
)

# More common in debug probes, servo buses (where a stray byte may cause motion) and GPS receivers than on
# boards.
_CABLE_ADAPTERS = frozenset({(0x0403, 0x6010), (0x0403, 0x6014), (0x067B, 0x2303)})


class UsbKind(Enum):
    """Whether a USB id belongs to a board."""

    BOARD = auto()
    LIKELY_BOARD = auto()
    UNKNOWN = auto()


def usb_kind(vendor_id: int | None, product_id: int | None) -> UsbKind:
    """Return the kind of device for a USB id."""
    board = board_of(vendor_id, product_id)
    usb_id = (vendor_id, product_id)
    # In its bootloader, a board interprets all data as an upload.
    if not board or usb_id in _CABLE_ADAPTERS or board.endswith("in its bootloader"):
        return UsbKind.UNKNOWN
    return UsbKind.LIKELY_BOARD if usb_id in _LIKELY_BOARDS else UsbKind.BOARD


def board_of(vendor_id: int | None, product_id: int | None) -> str:
    """Return the name of the device with a USB id, or an empty string."""
    if vendor_id is None or product_id is None:
        return ""
    if vendor_id in (_ARDUINO, _ARDUINO_ORG):
        # The second hexadecimal digit is the version of the board (0x0243 is an Uno R3).
        return _BOARDS.get(product_id) or _BOARDS.get(product_id & 0xFCFF, "Arduino")
    return _OTHERS.get((vendor_id, product_id), "")
