"""The queue of the messages to one topic id, and the source that fills it."""

from __future__ import annotations

from collections import deque

from rostether.graph.ports import Subscriber

# The overhead of a message besides its payload, so that the limit also applies to empty messages.
FRAME_OVERHEAD_BYTES = 8


class TopicQueue:
    """The queue of one topic id; it holds at most `depth` messages (None: only their bytes are limited)."""

    __slots__ = (
        "_source",
        "depth",
        "dropped_count",
        "is_source_paused",
        "payloads",
        "queued_bytes",
        "topic",
        "topic_id",
    )

    def __init__(self, topic_id: int, topic: str, depth: int | None = None) -> None:
        self.topic_id = topic_id
        self.topic = topic
        self.depth = depth
        self.payloads: deque[bytes] = deque()
        self.queued_bytes = 0
        self.dropped_count = 0
        self._source: Subscriber | None = None
        self.is_source_paused = False

    @property
    def has_source(self) -> bool:
        """Whether there is a publisher to pause."""
        return self._source is not None

    def set_source(self, source: Subscriber | None) -> None:
        """Set the source of the queue; the previous source is resumed."""
        self.resume_source()
        self._source = source

    def pop_ready(self, room_bytes: int) -> list[bytes]:
        """Remove and return the oldest messages that fill the room, at least one."""
        payloads = self.payloads
        if self.queued_bytes <= room_bytes:
            popped = list(payloads)
            payloads.clear()
            self.queued_bytes = 0
            return popped
        popped = []
        while room_bytes > 0 and payloads:
            payload = payloads.popleft()
            size = len(payload) + FRAME_OVERHEAD_BYTES
            self.queued_bytes -= size
            room_bytes -= size
            popped.append(payload)
        return popped

    def drop_oldest(self, limit_bytes: int) -> int:
        """Drop whole messages until the queue fits, but never the newest. Return how many."""
        dropped = 0
        while self.queued_bytes > limit_bytes and len(self.payloads) > 1:
            dropped += self._drop_one()
        self.dropped_count += dropped
        return dropped

    def drop_beyond_depth(self) -> int:
        """Drop the oldest messages beyond the depth. Return how many."""
        dropped = 0
        while self.depth is not None and len(self.payloads) > self.depth:
            dropped += self._drop_one()
        self.dropped_count += dropped
        return dropped

    def _drop_one(self) -> int:
        self.queued_bytes -= len(self.payloads.popleft()) + FRAME_OVERHEAD_BYTES
        return 1

    def pause_source(self) -> None:
        """Pause the source, unless it is paused."""
        if self._source is not None and not self.is_source_paused:
            self.is_source_paused = True
            self._source.pause()

    def resume_source(self) -> None:
        """Resume the source, if it is paused."""
        if self._source is not None and self.is_source_paused:
            self.is_source_paused = False
            self._source.resume()
