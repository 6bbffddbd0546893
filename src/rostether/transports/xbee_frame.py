"""XBee series 1 frames in API mode 2, sans I/O.

    7E | length u16 BE | frame data | checksum      checksum = FF - (sum of frame data)
    everything after 7E is escaped: 7E, 7D, 11 and 13 become 7D, byte ^ 20; length and sum count plain bytes

    01 | frame id | destination u16 BE | options | payload up to 100 bytes     send; frame id 0: no TX status
    81 | source u16 BE | signal strength | options | payload                   received

Source: Digi, XBee 802.15.4 RF Modules, "API operation".
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

# The radio's limit of one packet.
MAX_PAYLOAD_BYTES = 100
# The largest frame data of any kind that series 1 knows is a received packet with its 64-bit address; a
# longer length is a damaged one, and must not make us wait for its bytes.
MAX_FRAME_BYTES = 128

_DELIMITER = 0x7E
_ESCAPE = 0x7D
_ESCAPED_BIT = 0x20
_SPECIAL = frozenset((_DELIMITER, _ESCAPE, 0x11, 0x13))
_TX_16 = 0x01
_RX_16 = 0x81
_RX_HEADER_BYTES = 5
_LENGTH_BYTES = 2
_NO_STATUS = 0


class RadioPacket(NamedTuple):
    """One packet received over the air."""

    source: int
    payload: bytes


def encode_tx(destination: int, payload: bytes, *, frame_id: int = _NO_STATUS) -> bytes:
    """Return the escaped frame that sends at most 100 bytes to a 16-bit address."""
    if len(payload) > MAX_PAYLOAD_BYTES:
        raise ValueError(f"a radio packet can hold {MAX_PAYLOAD_BYTES} bytes, not {len(payload)}")
    return encode_frame(bytes((_TX_16, frame_id, *destination.to_bytes(2, "big"), 0)) + payload)


def encode_frame(data: bytes) -> bytes:
    """Return frame data as an escaped frame."""
    body = len(data).to_bytes(2, "big") + data + bytes((0xFF - sum(data) & 0xFF,))
    frame = bytearray((_DELIMITER,))
    for byte in body:
        if byte in _SPECIAL:
            frame += bytes((_ESCAPE, byte ^ _ESCAPED_BIT))
        else:
            frame.append(byte)
    return bytes(frame)


class XbeeFrameDecoder:
    """Finds frames in a byte stream cut anywhere; damaged ones are dropped."""

    def __init__(self) -> None:
        self._frame: bytearray | None = None
        self._escaped = False

    def feed(self, data: bytes) -> list[RadioPacket]:
        """Return the packets that the chunk completes; frames of other kinds are skipped."""
        packets = []
        for frame_data in self._frames(data):
            if len(frame_data) >= _RX_HEADER_BYTES and frame_data[0] == _RX_16:
                source = int.from_bytes(frame_data[1:3], "big")
                packets.append(RadioPacket(source, frame_data[_RX_HEADER_BYTES:]))
        return packets

    def _frames(self, data: bytes) -> Iterator[bytes]:
        for byte in data:
            if byte == _DELIMITER:
                # Unescaped it can only begin a frame, whatever was under way.
                self._frame = bytearray()
                self._escaped = False
                continue
            if self._frame is None:
                continue
            if byte == _ESCAPE:
                self._escaped = True
                continue
            self._frame.append(byte ^ _ESCAPED_BIT if self._escaped else byte)
            self._escaped = False
            if (frame_data := self._finish(self._frame)) is not None:
                yield frame_data

    def _finish(self, frame: bytearray) -> bytes | None:
        if len(frame) < _LENGTH_BYTES:
            return None
        length = int.from_bytes(frame[:_LENGTH_BYTES], "big")
        if length > MAX_FRAME_BYTES:
            self._frame = None
            return None
        if len(frame) < _LENGTH_BYTES + length + 1:
            return None
        self._frame = None
        is_sound = sum(frame[_LENGTH_BYTES:]) & 0xFF == 0xFF
        return bytes(frame[_LENGTH_BYTES:-1]) if is_sound else None
