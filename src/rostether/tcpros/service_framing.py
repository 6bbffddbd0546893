"""Answers on a TCPROS service connection: a flag for success, then the response or the error's text.

    uint8 ok | uint32 length | payload            (little endian; requests are framed like messages)

ok = 1: the payload is the response message. ok = 0: it is the server's error text in UTF-8.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from rostether.errors import RemoteProtocolError
from rostether.tcpros.message_framing import MAX_MESSAGE_BYTES

# Errors are read by users; longer texts are cut before they are sent.
MAX_ERROR_TEXT_BYTES = 64 << 10

_HEAD = struct.Struct("<BI")


class ServiceAnswer(NamedTuple):
    """One answer; `payload` is the response, or the error's text if not `is_ok`."""

    is_ok: bool
    payload: bytes

    @property
    def error_text(self) -> str:
        """The payload as text."""
        return self.payload.decode("utf-8", "replace")


def encode_response(payload: bytes) -> bytes:
    """Return a successful answer."""
    return _HEAD.pack(1, len(payload)) + payload


def encode_error(text: str) -> bytes:
    """Return a failed answer with its reason."""
    encoded = text.encode("utf-8", "replace")[:MAX_ERROR_TEXT_BYTES]
    return _HEAD.pack(0, len(encoded)) + encoded


class AnswerDecoder:
    """Splits a byte stream, in chunks that may end anywhere, into answers."""

    def __init__(self, max_message_bytes: int = MAX_MESSAGE_BYTES) -> None:
        self._max_message_bytes = max_message_bytes
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[ServiceAnswer]:
        """Handle a chunk and return the answers that are complete.

        Raises RemoteProtocolError for a length above the limit.
        """
        self._buffer += data
        answers = []
        position, end = 0, len(self._buffer)
        while end - position >= _HEAD.size:
            ok, length = _HEAD.unpack_from(self._buffer, position)
            if length > self._max_message_bytes:
                raise RemoteProtocolError(
                    f"the service announced an answer of {length} bytes, more than {self._max_message_bytes}"
                )
            start = position + _HEAD.size
            if start + length > end:
                break
            position = start + length
            answers.append(ServiceAnswer(bool(ok), bytes(self._buffer[start:position])))
        del self._buffer[:position]
        return answers
