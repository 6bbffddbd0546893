"""Frames of an XBee radio's API, sans I/O.

    7E | length u16 BE | frame data | checksum      checksum = FF - (sum of frame data)

In API mode 2 everything after 7E is escaped: 7E, 7D, 11 and 13 become 7D, byte ^ 20; length and sum count
plain bytes. API mode 1 escapes nothing.

Source: Digi, XBee 802.15.4 RF Modules and XBee 3 User Guides, "API operation".
"""

from __future__ import annotations

from collections.abc import Iterator

# The largest frame data is a received packet with its 64-bit address and 256 bytes, which the 900 MHz radios
# send. A larger length is damaged: the decoder must not wait for its bytes.
MAX_FRAME_BYTES = 272

_DELIMITER = 0x7E
_ESCAPE = 0x7D
_ESCAPED_BIT = 0x20
_SPECIAL = frozenset((_DELIMITER, _ESCAPE, 0x11, 0x13))
_LENGTH_BYTES = 2


def encode_frame(data: bytes, *, escaped: bool = True) -> bytes:
    """Return frame data as a frame, of API mode 2 if `escaped`, else of mode 1."""
    body = len(data).to_bytes(2, "big") + data + bytes((0xFF - sum(data) & 0xFF,))
    frame = bytearray((_DELIMITER,))
    for byte in body:
        if escaped and byte in _SPECIAL:
            frame += bytes((_ESCAPE, byte ^ _ESCAPED_BIT))
        else:
            frame.append(byte)
    return bytes(frame)


class XbeeFrameDecoder:
    """Finds frames in a byte stream cut anywhere; damaged ones are dropped."""

    def __init__(self, *, escaped: bool = True) -> None:
        self._escapes = escaped
        self._frame: bytearray | None = None
        self._is_escaped = False

    def feed(self, data: bytes) -> list[bytes]:
        """Return the frame data of the frames that the chunk completes."""
        return list(self._frames(data))

    def _frames(self, data: bytes) -> Iterator[bytes]:
        for byte in data:
            if byte == _DELIMITER and (self._escapes or self._frame is None):
                # In escaped mode, this byte can only begin a frame, whatever was in progress.
                self._frame = bytearray()
                self._is_escaped = False
                continue
            if self._frame is None:
                continue
            if byte == _ESCAPE and self._escapes:
                self._is_escaped = True
                continue
            self._frame.append(byte ^ _ESCAPED_BIT if self._is_escaped else byte)
            self._is_escaped = False
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
        is_valid = sum(frame[_LENGTH_BYTES:]) & 0xFF == 0xFF
        return bytes(frame[_LENGTH_BYTES:-1]) if is_valid else None
