"""Messages on a TCPROS topic connection, and requests on a service connection: length, then payload.

    uint32 length | payload | uint32 length | payload | ...     (little endian)

Both directions work on whole chunks, because at 200,000 messages a second each step for a message is
expensive. A batch of equal lengths is framed by one `join`. A chunk of equal lengths is split by a
comprehension, after a check in C that all its prefixes are the same.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from rostether.errors import RemoteProtocolError

# Four times the largest messages in practice (64 MB point clouds): a peer with a larger length lost its
# framing or is hostile. Memory is allocated only for received bytes.
MAX_MESSAGE_BYTES = 256 << 20

_LENGTH = struct.Struct("<I")
_pack_length = _LENGTH.pack
_unpack_length = _LENGTH.unpack_from

# The number of messages from which a search for a run of equal lengths is faster (measured).
_MIN_RUN = 8


def encode_messages(payloads: Sequence[bytes]) -> bytes:
    """Return a batch of payloads, each behind its length."""
    if len(payloads) == 1:
        return _pack_length(len(payloads[0])) + payloads[0]
    if not payloads:
        return b""
    if len(set(map(len, payloads))) == 1:
        prefix = _pack_length(len(payloads[0]))
        return prefix + prefix.join(payloads)
    parts = [b""] * (2 * len(payloads))
    parts[::2] = map(_pack_length, map(len, payloads))
    parts[1::2] = payloads
    return b"".join(parts)


def measure_oldest(data: bytes, excess_bytes: int) -> tuple[int, int]:
    """Count the oldest messages of an encoded batch until they have `excess_bytes`.

    Returns their bytes and their number; the last message of the batch never counts.
    """
    position, count, end = 0, 0, len(data)
    while position < excess_bytes:
        following = position + 4 + _unpack_length(data, position)[0]
        if following >= end:
            break
        position = following
        count += 1
    return position, count


class MessageDecoder:
    """Splits a byte stream, in chunks that may end anywhere, into payloads."""

    def __init__(self, max_message_bytes: int = MAX_MESSAGE_BYTES) -> None:
        self._max_message_bytes = max_message_bytes
        self._prefix = b""  # the first bytes of an incomplete length
        # A payload that spans chunks is a list of its pieces until it is whole: each byte is copied once.
        self._pieces: list[bytes] = []
        self._missing_bytes = 0

    def feed(self, data: bytes) -> list[bytes]:
        """Handle a chunk and return the payloads that are complete, in order.

        Raises RemoteProtocolError for a length above the limit: the connection cannot continue.
        """
        payloads: list[bytes] = []
        if self._missing_bytes:
            missing_bytes = self._missing_bytes
            if len(data) < missing_bytes:
                self._pieces.append(data)
                self._missing_bytes -= len(data)
                return payloads
            self._pieces.append(data[:missing_bytes])
            payloads.append(b"".join(self._pieces))
            self._pieces.clear()
            self._missing_bytes = 0
            data = data[missing_bytes:]
        elif self._prefix:
            data = self._prefix + data
            self._prefix = b""
        position = self._split_run(data, payloads)
        end = len(data)
        last = end - 4
        limit = self._max_message_bytes
        append = payloads.append
        while position <= last:
            length = _unpack_length(data, position)[0]
            if length > limit:
                raise self._too_long(length)
            start = position + 4
            position = start + length
            if position > end:
                self._pieces.append(data[start:])
                self._missing_bytes = position - end
                return payloads
            append(data[start:position])
        self._prefix = data[position:]
        return payloads

    def _split_run(self, data: bytes, payloads: list[bytes]) -> int:
        """Split the chunk in one step if all its messages have the same length; return its end."""
        end = len(data)
        if end < 4 * _MIN_RUN:
            return 0
        length: int = _unpack_length(data)[0]
        if length > self._max_message_bytes:
            raise self._too_long(length)
        stride = length + 4
        count = end // stride
        if count < _MIN_RUN:
            return 0
        run_end = count * stride
        for index in range(4):
            if data[index:run_end:stride].count(data[index]) != count:
                return 0
        payloads += [data[start : start + length] for start in range(4, run_end + 1, stride)]
        return run_end

    def _too_long(self, length_bytes: int) -> RemoteProtocolError:
        return RemoteProtocolError(
            f"the peer announced a message of {length_bytes} bytes, more than {self._max_message_bytes}"
        )
