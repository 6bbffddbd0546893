"""One subscriber of a publisher: its queue keeps a slow subscriber from delaying the others."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Mapping
from weakref import WeakValueDictionary

from rostether.graph.flow_control import PublicationFlow, Reader, SubscriberFlow
from rostether.mechanisms.tasks import occurs_within
from rostether.ros1.tcpros_connection import CLOSE_GRACE_S, ConnectionRecord, keep_unsent
from rostether.tcpros.message_framing import measure_oldest

# A subscriber that is often too slow for a moment would fill the log; the line has the total of lost
# messages.
SLOW_REPORT_INTERVAL_S = 10.0

# The bytes of a queue that are joined for one write. More bytes would wait in the transport, where they
# cannot be dropped, and the progress of a slow subscriber would be noticed late.
_WRITE_BYTES = 64 << 10


# The readers of all publications in this process, by caller id and topic.
_readers: WeakValueDictionary[tuple[str, str], Reader] = WeakValueDictionary()


class SubscriberConnection(asyncio.Protocol):
    """Sends encoded batches; the rest waits in a bounded queue, which drops the oldest messages first.

    `greeting` is sent first: the header, and the latched message if there is one. `on_drop` is called when it
    begins to lose messages, at most every SLOW_REPORT_INTERVAL_S, and `on_lost` when the connection ends.
    """

    def __init__(
        self,
        transport: asyncio.Transport,
        fields: Mapping[str, str],
        flow: PublicationFlow,
        *,
        topic: str,
        greeting: bytes,
        queue_bytes: int,
        on_drop: Callable[[SubscriberConnection], None],
        on_lost: Callable[[SubscriberConnection], None],
    ) -> None:
        self.record = ConnectionRecord(
            transport, peer=fields.get("callerid", "unknown"), topic=topic, direction="o"
        )
        self.dropped_count = 0
        self._transport = transport
        self._greeting = greeting
        self._limit_bytes = queue_bytes
        reader = _readers.setdefault((self.record.peer, topic), Reader())
        self._flow = SubscriberFlow(flow, self._backlog_bytes, queue_bytes, reader)
        self._queue: deque[tuple[bytes, int]] = deque()
        self._queued_bytes = 0
        self._loop = asyncio.get_running_loop()
        self._accepts_more = True
        self._is_dropping = False
        # The earliest time of the next report.
        self._may_report_s = 0.0
        self._on_drop = on_drop
        self._on_lost = on_lost
        self._lost = asyncio.Event()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start to send."""
        keep_unsent(self._transport)
        self._transport.write(self._greeting)
        self._greeting = b""

    def send(self, data: bytes, count: int) -> int:
        """Send a batch of `count` messages; return how many older ones were dropped for it."""
        self.record.byte_count += len(data)
        self.record.message_count += count
        if self._accepts_more:
            self._flow.reader.read_count += 1
            self._transport.write(data)
            return 0
        self._queue.append((data, count))
        self._queued_bytes += len(data)
        dropped = self._drop_oldest() if self._queued_bytes > self._limit_bytes else 0
        self._flow.update()
        return dropped

    async def close(self) -> None:
        """Send the queued data for at most CLOSE_GRACE_S, then end the connection."""
        self._transport.write(b"".join([data for data, _ in self._queue]))
        self._clear()
        self._transport.close()
        if not await occurs_within(self._lost, CLOSE_GRACE_S):
            self._transport.abort()
            await self._lost.wait()

    def data_received(self, data: bytes) -> None:
        """Ignore data from a subscriber; the protocol defines none."""

    def pause_writing(self) -> None:
        """Queue messages: the socket is full."""
        self._accepts_more = False
        self._flow.update()

    def resume_writing(self) -> None:
        """Write the queue, oldest first, until the socket is full again."""
        self._accepts_more = True
        while self._queue and self._accepts_more:
            parts = []
            size_bytes = 0
            while self._queue and size_bytes < _WRITE_BYTES:
                data, _ = self._queue.popleft()
                parts.append(data)
                size_bytes += len(data)
            self._queued_bytes -= size_bytes
            self._transport.write(parts[0] if len(parts) == 1 else b"".join(parts))
        if not self._queue:
            self._is_dropping = False
        self._flow.note_sent()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._clear()
        self._flow.end()
        self._lost.set()
        self._on_lost(self)

    def _clear(self) -> None:
        self._queue.clear()
        self._queued_bytes = 0

    def _backlog_bytes(self) -> int:
        return self._queued_bytes + self._transport.get_write_buffer_size()

    def _drop_oldest(self) -> int:
        """Drop messages until the queue is within its limit, but keep the newest."""
        dropped = 0
        excess_bytes = self._queued_bytes - self._limit_bytes
        while excess_bytes > 0:
            data, count = self._queue[0]
            is_last = len(self._queue) == 1
            if is_last or len(data) > excess_bytes:
                cut_bytes, cut_count = measure_oldest(data, excess_bytes)
                if cut_bytes >= excess_bytes or is_last:
                    self._queue[0] = (data[cut_bytes:], count - cut_count)
                    self._queued_bytes -= cut_bytes
                    dropped += cut_count
                    break
            self._queue.popleft()
            self._queued_bytes -= len(data)
            excess_bytes -= len(data)
            dropped += count
        self.dropped_count += dropped
        if dropped and not self._is_dropping:
            self._is_dropping = True
            if self._loop.time() >= self._may_report_s:
                self._may_report_s = self._loop.time() + SLOW_REPORT_INTERVAL_S
                self._on_drop(self)
        return dropped
