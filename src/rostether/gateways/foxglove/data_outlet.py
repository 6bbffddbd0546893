"""Sends the messages of topics to one client: collects them for up to `GATHER_S`, or queues them.

The messages bypass the WebSocket library, which would cost too much for each. If a client reads slowly,
they wait in bounded queues, which drop the oldest first.
"""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Callable, Sequence

from rostether.gateways.websocket.topic_queues import TopicQueues

# The first byte of a frame that contains a whole binary message.
_BINARY = 0x82
_MESSAGE_DATA = 0x01
_HEADER_BYTES = 13
_SHORT = struct.Struct("<BBBIQ")
_MEDIUM = struct.Struct("<BB2sBIQ")
_LONG = struct.Struct("<BB8sBIQ")

# If no message was sent for this time, a message is sent immediately. In a flood, messages are sent together,
# less often than a screen is drawn: a write costs more than all other steps.
GATHER_S = 0.01

# Above this size, collected data is written before `GATHER_S`: a socket accepts this much at once.
_GATHERED_BYTES = 256 << 10

# Viewers show the current state: camera images and other large data that have waited longer are dropped.
_MAX_AGE_S = 1.0

# The amount of waiting data per write: enough for one system call.
_DRAIN_BYTES = 64 << 10


class DataOutlet:
    """The messages of topics on their way to one client.

    `write` sends bytes; `dropped` is called with the number of messages that were lost since its last call.
    """

    def __init__(
        self, waiting_bytes: int, write: Callable[[bytes], None], dropped: Callable[[int], None]
    ) -> None:
        self._is_open = True
        self._write = write
        self._dropped = dropped
        self._loop = asyncio.get_running_loop()
        self._pieces: list[bytes] = []
        self._pieces_bytes = 0
        self._is_flush_due = False
        self._flushed_s = 0.0
        self._is_paused = False
        self._waiting: TopicQueues[int, int] = TopicQueues(waiting_bytes, self._count_drop)
        self._dropped_count = 0

    def end(self) -> None:
        """Stop writing."""
        self._is_open = False
        self._pieces.clear()
        self._pieces_bytes = 0

    def pause(self) -> None:
        """Keep messages waiting."""
        self._is_paused = True

    def resume(self) -> None:
        """Send the waiting messages."""
        self._is_paused = False
        self._drain()

    def send(
        self, subscription_id: int, time_ns: int, payloads: Sequence[bytes], *, is_latched: bool = False
    ) -> None:
        """Send messages of a topic, or queue them; latched ones are not sent again, so they may be old."""
        if not self._is_open:
            return
        if self._is_paused or self._waiting:
            max_age_s = None if is_latched else _MAX_AGE_S
            self._waiting.add(subscription_id, time_ns, payloads, self._loop.time(), max_age_s=max_age_s)
            if self._dropped_count:
                self._dropped(self._dropped_count)
                self._dropped_count = 0
            return
        self._pieces_bytes += add_data_frames(self._pieces, subscription_id, time_ns, payloads)
        if self._pieces_bytes > _GATHERED_BYTES:
            self.flush()
        elif not self._is_flush_due:
            self._is_flush_due = True
            due_s = self._flushed_s + GATHER_S
            if self._loop.time() >= due_s:
                # Later messages of this iteration of the loop are sent together with it.
                self._loop.call_soon(self._flush_due)
            else:
                self._loop.call_at(due_s, self._flush_due)

    def forget(self, subscription_id: int) -> None:
        """Discard the waiting messages of a subscription that has ended."""
        self._waiting.forget(subscription_id)

    def flush(self) -> None:
        """Write the collected messages."""
        pieces = self._pieces
        if not pieces:
            return
        self._pieces, self._pieces_bytes = [], 0
        if not self._is_open:
            return
        self._flushed_s = self._loop.time()
        self._write(b"".join(pieces))

    def _flush_due(self) -> None:
        self._is_flush_due = False
        self.flush()

    def _drain(self) -> None:
        while self._waiting and not self._is_paused and self._is_open:
            while self._waiting and self._pieces_bytes < _DRAIN_BYTES:
                subscription_id, time_ns, payload = self._waiting.pop()
                self._pieces_bytes += add_data_frames(self._pieces, subscription_id, time_ns, [payload])
            self.flush()

    def _count_drop(self, _subscription_id: int) -> None:
        self._dropped_count += 1


def add_data_frames(
    pieces: list[bytes], subscription_id: int, time_ns: int, payloads: Sequence[bytes]
) -> int:
    """Append the WebSocket frames of payloads to the pieces to write; return their size in bytes.

    Source: RFC 6455, 5.2; the opcode "Message Data" of Foxglove's protocol.
    """
    size = 0
    for payload in payloads:
        length = len(payload) + _HEADER_BYTES
        if length < 126:
            header = _SHORT.pack(_BINARY, length, _MESSAGE_DATA, subscription_id, time_ns)
        elif length < 65536:
            header = _MEDIUM.pack(
                _BINARY, 126, length.to_bytes(2, "big"), _MESSAGE_DATA, subscription_id, time_ns
            )
        else:
            header = _LONG.pack(
                _BINARY, 127, length.to_bytes(8, "big"), _MESSAGE_DATA, subscription_id, time_ns
            )
        pieces.append(header)
        pieces.append(payload)
        size += len(header) + len(payload)
    return size
