"""Packets of the DYNAMIXEL protocol 2.0 as bytes.

    ff ff fd 00 | id | length u16 | instruction | parameters | CRC u16

Numbers are little endian. The length counts the bytes from the instruction to the CRC. After each ff ff fd
from the instruction to the last parameter, an additional fd is sent (byte stuffing).

Source: ROBOTIS e-Manual, DYNAMIXEL Protocol 2.0.
"""

from __future__ import annotations

from enum import IntEnum

from msgspec import Struct

HEADER = b"\xff\xff\xfd\x00"
BROADCAST_ID = 0xFE
# The longest control table has 661 bytes; a much larger length is noise.
MAX_LENGTH = 1024

_STUFFED = b"\xff\xff\xfd"
_PREFIX_BYTES = len(HEADER) + 3


class Instruction(IntEnum):
    """The instruction of a packet."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    REBOOT = 0x08
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83


class ServoError(IntEnum):
    """The errors that a servo reports in a status packet."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


# Added to the error while the servo has a hardware error.
ALERT = 0x80


class Packet(Struct, frozen=True):
    """One packet, without stuffing."""

    id: int
    instruction: int
    parameters: bytes


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF
        table.append(crc)
    return table


_CRC_TABLE = _crc_table()


def crc16(data: bytes | bytearray) -> int:
    """Return the CRC with the polynomial 0x8005, start value 0, most significant bit first."""
    crc = 0
    for byte in data:
        crc = (crc << 8 ^ _CRC_TABLE[crc >> 8 ^ byte]) & 0xFFFF
    return crc


def encode_packet(servo_id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Return the bytes of a packet."""
    body = (bytes((instruction,)) + parameters).replace(_STUFFED, _STUFFED + b"\xfd")
    packet = HEADER + bytes((servo_id,)) + (len(body) + 2).to_bytes(2, "little") + body
    return packet + crc16(packet).to_bytes(2, "little")


class PacketReader:
    """Finds packets in received bytes; those with a wrong length or CRC are dropped."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[Packet]:
        """Return the packets that end in `data`."""
        self._buffer += data
        packets: list[Packet] = []
        while self._find_header():
            length = int.from_bytes(self._buffer[5:7], "little")
            is_valid = 3 <= length <= MAX_LENGTH
            end = _PREFIX_BYTES + length
            if is_valid and len(self._buffer) < end:
                break
            crc = int.from_bytes(self._buffer[end - 2 : end], "little")
            if not is_valid or crc16(self._buffer[: end - 2]) != crc:
                # A valid packet can begin inside the damaged one.
                del self._buffer[0]
                continue
            body = bytes(self._buffer[_PREFIX_BYTES : end - 2]).replace(_STUFFED + b"\xfd", _STUFFED)
            packets.append(Packet(self._buffer[4], body[0], body[1:]))
            del self._buffer[:end]
        return packets

    def _find_header(self) -> bool:
        """Remove the bytes before a header; return whether id and length have arrived too."""
        start = self._buffer.find(HEADER)
        if start < 0:
            # The last bytes can be the beginning of a header.
            del self._buffer[: max(0, len(self._buffer) - len(HEADER) + 1)]
            return False
        del self._buffer[:start]
        return len(self._buffer) >= _PREFIX_BYTES
