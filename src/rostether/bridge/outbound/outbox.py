"""The output to one board: control traffic first, then one bounded queue for each topic, in turn.

On links with flow control (TCP, pty), a queue that overflows pauses its source: the messages wait in ROS, and
none is lost. The pause ends if the board accepts no byte for a second. On other links, and for a board that
accepts nothing, the oldest messages of the topic are dropped. Control traffic and responses never wait in a
queue.
"""

from __future__ import annotations

from asyncio import AbstractEventLoop, TimerHandle
from collections import deque
from collections.abc import Callable, Sequence

from rostether.bridge.outbound.line_pacer import LinePacer
from rostether.bridge.outbound.topic_queue import FRAME_OVERHEAD_BYTES, TopicQueue
from rostether.bridge.settings import BridgeSettings
from rostether.errors import LocalProtocolError
from rostether.rosserial.host_link import HostLink
from rostether.transports.transport import Transport

# On a line with a baud rate, a command older than this is dropped rather than sent late.
QUEUE_LINE_S = 2.0
# The queue of a slow line still holds a burst of small commands.
MIN_QUEUE_BYTES = 8 * 1024
# While its source is paused, a queue may hold this many times its limit: data that the source has already
# read still arrives.
PAUSED_QUEUE_FACTOR = 8
# The bytes that one topic sends before the next one: many small messages, but short turns.
TURN_BYTES = 4 * 1024
# The size of one write; other boards are served between two writes.
WRITE_BYTES = 256 * 1024
# After a pause of this length, up to this number of messages are written immediately. Other messages are
# collected for one write per turn of the event loop, which costs less.
EAGER_AFTER_S = 0.0005
EAGER_MESSAGES = 16
# How often a paused source checks whether the board still accepts bytes.
STALL_CHECK_S = 0.1


class Outbox:
    """Queues everything that one session writes.

    `on_dropped(queue, count)` is called for each overflow. `baud` is the baud rate, if there is one.
    """

    def __init__(
        self,
        transport: Transport,
        link: HostLink,
        loop: AbstractEventLoop,
        *,
        on_dropped: Callable[[TopicQueue, int], None],
        settings: BridgeSettings,
        baud: int | None = None,
    ) -> None:
        self._transport = transport
        self._link = link
        self._unread = link.unread
        self._loop = loop
        self._on_dropped = on_dropped
        self._stall_s = settings.stall_s
        self._unsent_limit_bytes = settings.unsent_bytes
        self._pacer = LinePacer(baud) if baud else None
        self._limit_bytes = settings.queue_bytes
        if self._pacer is not None:
            line_bytes = int(self._pacer.bytes_per_s * QUEUE_LINE_S)
            self._limit_bytes = min(settings.queue_bytes, max(MIN_QUEUE_BYTES, line_bytes))
        self._waits_for_board = transport.can_pause and self._pacer is None
        self._ready: deque[TopicQueue] = deque()
        self._drained: list[TopicQueue] = []
        self._answers: list[bytes] = []
        self._is_scheduled = False
        self._flushed_s = 0.0
        self._paced: TimerHandle | None = None
        self._is_blocked = False
        self._is_stalled = False
        self._stall_check: TimerHandle | None = None
        self._unsent_bytes = 0
        self._progress_s = 0.0
        self.sent_bytes = 0

    @property
    def queued_bytes(self) -> int:
        """How many bytes wait in the topics' queues."""
        return sum(queue.queued_bytes for queue in self._ready)

    def put(self, queue: TopicQueue, payloads: Sequence[bytes]) -> None:
        """Queue messages of one topic.

        They are written by the end of this turn of the event loop if the link accepts them.
        """
        if len(payloads) <= EAGER_MESSAGES and self._is_idle():
            self._send_now(queue, payloads)
            return
        if not queue.payloads:
            self._ready.append(queue)
        queue.payloads.extend(payloads)
        queue.queued_bytes += sum(map(len, payloads)) + FRAME_OVERHEAD_BYTES * len(payloads)
        if queue.depth is not None and len(queue.payloads) > queue.depth:
            self._overflow_depth(queue)
        if queue.queued_bytes > self._limit_bytes:
            self._overflow(queue)
        if not self._is_scheduled:
            self._schedule()

    def answer(self, topic_id: int, payload: bytes) -> None:
        """Send the request or response of a service, before all topics.

        Raises LocalProtocolError for an id that the board did not announce, or a payload above its buffer
        size.
        """
        self._answers.append(self._link.encode_message(topic_id, payload))
        if not self._is_scheduled:
            self._schedule()

    def remove(self, queue: TopicQueue) -> None:
        """Remove a topic and its waiting messages."""
        if queue in self._ready:
            self._ready.remove(queue)
        queue.payloads.clear()
        queue.queued_bytes = 0
        queue.set_source(None)

    def flush(self) -> None:
        """Write responses, then control traffic, then messages as far as the link accepts them."""
        self._is_scheduled = False
        # Responses first: the link may have delayed control traffic until the response was made.
        pieces, self._answers = self._answers, []
        control = self._link.data_to_send()
        if control:
            pieces.append(control)
        if self._is_blocked:
            if pieces and self._transport.write_buffer_bytes < self._unsent_limit_bytes:
                self._write(pieces)
            return
        board_room = self._unread.room_bytes
        if self._ready:
            if board_room is not None:
                self._encode_fitting(pieces, board_room)
            elif self._pacer is None:
                self._encode_ready(pieces, WRITE_BYTES)
            elif (room := self._pacer.room_bytes(self._loop.time())) > 0:
                self._encode_ready(pieces, room)
        if pieces:
            self._flushed_s = self._loop.time()
            self._write(pieces)
        if self._drained:
            # Sources resume last: new data from them must follow the data that was just written.
            drained, self._drained = self._drained, []
            for queue in drained:
                queue.resume_source()
        # For a board without room, the link's next event or timer brings the next flush.
        if self._ready and not self._is_scheduled and board_room is None:
            self._schedule()

    def pause_writing(self) -> None:
        """Stop writing topics: the transport's buffer is full."""
        self._is_blocked = True
        self._unsent_bytes = self._transport.write_buffer_bytes
        self._progress_s = self._loop.time()

    def resume_writing(self) -> None:
        """Continue to write topics: the transport's buffer has room."""
        self._is_blocked = False
        self._is_stalled = False
        if not self._is_scheduled:
            self._schedule()

    def close(self) -> None:
        """Release every source and timer, and stop writing."""
        self._is_blocked = True
        for timer in (self._paced, self._stall_check):
            if timer is not None:
                timer.cancel()
        for queue in self._ready:
            queue.resume_source()
        self._ready.clear()

    def _is_idle(self) -> bool:
        return (
            not (self._ready or self._is_scheduled or self._is_blocked)
            and self._pacer is None
            and self._unread.room_bytes is None
            and self._loop.time() - self._flushed_s > EAGER_AFTER_S
        )

    def _send_now(self, queue: TopicQueue, payloads: Sequence[bytes]) -> None:
        self._flushed_s = self._loop.time()
        frames = self._encode(queue, payloads)
        if frames:
            self.sent_bytes += len(frames)
            self._transport.write(frames)

    def _encode(self, queue: TopicQueue, payloads: Sequence[bytes]) -> bytes:
        try:
            frames = self._link.encode_messages(queue.topic_id, payloads)
        except LocalProtocolError:
            # The board no longer subscribes to the topic, for example after a reset with another sketch.
            queue.dropped_count += len(payloads)
            return b""
        return frames

    def _schedule(self) -> None:
        if self._is_blocked and not self._answers:
            return
        if self._pacer is not None and not self._answers:
            now_s = self._loop.time()
            if self._pacer.room_bytes(now_s) <= 0:
                if self._paced is None:
                    self._paced = self._loop.call_later(self._pacer.wait_s(now_s), self._paced_flush)
                return
        self._is_scheduled = True
        self._loop.call_soon(self.flush)

    def _paced_flush(self) -> None:
        self._paced = None
        if self._pacer is not None:
            self._pacer.observe(self._transport.write_buffer_bytes, self._loop.time())
        self.flush()

    def _encode_ready(self, pieces: list[bytes], room_bytes: int) -> None:
        ready = self._ready
        while room_bytes > 0 and ready:
            queue = ready.popleft()
            payloads = queue.pop_ready(room_bytes if not ready else min(room_bytes, TURN_BYTES))
            if queue.payloads:
                ready.append(queue)
            frames = self._encode(queue, payloads)
            if not frames:
                continue
            room_bytes -= len(frames)
            pieces.append(frames)
            if queue.is_source_paused and queue.queued_bytes <= self._limit_bytes // 2:
                self._drained.append(queue)

    def _encode_fitting(self, pieces: list[bytes], room_bytes: int) -> None:
        for queue in list(self._ready):
            while queue.payloads and len(queue.payloads[0]) + FRAME_OVERHEAD_BYTES <= room_bytes:
                frames = self._encode(queue, queue.pop_ready(1))
                room_bytes -= len(frames)
                pieces.append(frames)
            if not queue.payloads:
                self._ready.remove(queue)
                if queue.is_source_paused:
                    self._drained.append(queue)

    def _write(self, pieces: list[bytes]) -> None:
        data = pieces[0] if len(pieces) == 1 else b"".join(pieces)
        self.sent_bytes += len(data)
        if self._pacer is not None:
            self._pacer.written(len(data), self._loop.time())
        self._transport.write(data)

    def _overflow_depth(self, queue: TopicQueue) -> None:
        if not self._is_blocked and self._pacer is None:
            self.flush()
        if dropped := queue.drop_beyond_depth():
            self._on_dropped(queue, dropped)

    def _overflow(self, queue: TopicQueue) -> None:
        if not self._is_blocked and self._pacer is None:
            self.flush()
            if queue.queued_bytes <= self._limit_bytes:
                return
        limit_bytes = self._limit_bytes
        if self._waits_for_board and not self._is_stalled and queue.has_source:
            queue.pause_source()
            limit_bytes *= PAUSED_QUEUE_FACTOR
            if self._stall_check is None:
                self._stall_check = self._loop.call_later(STALL_CHECK_S, self._check_stall)
        if dropped := queue.drop_oldest(limit_bytes):
            self._on_dropped(queue, dropped)

    def _check_stall(self) -> None:
        self._stall_check = None
        if not any(queue.is_source_paused for queue in self._ready):
            return
        now_s = self._loop.time()
        unsent_bytes = self._transport.write_buffer_bytes
        if unsent_bytes != self._unsent_bytes or not self._is_blocked:
            self._unsent_bytes = unsent_bytes
            self._progress_s = now_s
        elif now_s - self._progress_s >= self._stall_s:
            self._is_stalled = True
            for queue in self._ready:
                queue.resume_source()
            return
        self._stall_check = self._loop.call_later(STALL_CHECK_S, self._check_stall)
