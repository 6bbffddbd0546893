"""What waits to be sent to one client: answers first come, first served, and messages of topics.

A topic that comes faster than its client reads loses its oldest messages, counted; a client that does not
read the answers that it asked for is given up. Messages are put into words when they leave: what is dropped
costs nothing.
"""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass
from typing import Any, TypeAlias

from rostether.gateways.shared_subscriptions import Batch

Frame: TypeAlias = str | bytes

MAX_STATUSES = 100
"""Statuses that wait; who sends mistakes faster than it reads the answers misses some."""


class TopicQueue:
    """The messages of one topic that wait for one client; `owner` is the subscription that wants them."""

    def __init__(self, length: int, owner: Any = None) -> None:
        self.owner = owner
        self.length = max(length, 1)
        self.waiting: deque[tuple[Batch, int]] = deque()
        self.dropped_count = 0
        self.told_count = 0
        """How many of the dropped messages were reported to the client."""
        self.tell_at_s = 0.0
        self.places = 0
        """How often it stands in its client's line."""


@dataclass(frozen=True, slots=True)
class Due:
    """One message that is to be sent now."""

    queue: TopicQueue
    batch: Batch
    index: int


class Outbox:
    """The bounded queues of one client."""

    def __init__(self, max_topic_bytes: int, max_control_bytes: int) -> None:
        self.is_overflowing = False
        """Whether the client has left its answers unread for so long that nothing more is kept."""
        self._max_topic_bytes = max_topic_bytes
        self._max_control_bytes = max_control_bytes
        self._control_bytes = 0
        self._topic_bytes = 0
        self._statuses = 0
        # In order of arrival; a topic stands in it as often as it has messages waiting.
        self._line: deque[TopicQueue | tuple[Frame, bool]] = deque()
        self._news = asyncio.Event()

    @property
    def topic_bytes(self) -> int:
        """The payloads of topics that wait."""
        return self._topic_bytes

    def answer(self, frame: Frame, *, is_status: bool = False) -> None:
        """Queue an answer."""
        if is_status:
            if self._statuses >= MAX_STATUSES:
                return
            self._statuses += 1
        if self._control_bytes + len(frame) > self._max_control_bytes and self._control_bytes:
            self.is_overflowing = True
            self._news.set()
            return
        self._control_bytes += len(frame)
        self._line.append((frame, is_status))
        self._news.set()

    def put(self, queue: TopicQueue, batch: Batch, index: int) -> None:
        """Queue a topic's message; the topic's oldest ones go where there is no room."""
        size = len(batch.payloads[index])
        waiting = queue.waiting
        waiting.append((batch, index))
        self._topic_bytes += size
        while len(waiting) > 1 and (len(waiting) > queue.length or self._topic_bytes > self._max_topic_bytes):
            old, old_index = waiting.popleft()
            self._topic_bytes -= len(old.payloads[old_index])
            queue.dropped_count += 1
        # The places of those that went are taken by those behind them.
        if queue.places < len(waiting):
            queue.places += 1
            self._line.append(queue)
        self._news.set()

    def discard(self, queue: TopicQueue) -> None:
        """Forget what waits of a topic."""
        for batch, index in queue.waiting:
            self._topic_bytes -= len(batch.payloads[index])
        queue.waiting.clear()
        queue.places = 0
        self._line = deque(each for each in self._line if each is not queue)

    async def wait(self) -> None:
        """Wait until there may be something to send."""
        if not self._line and not self.is_overflowing:
            self._news.clear()
            await self._news.wait()

    def next(self) -> Frame | Due | None:
        """Return what is to be sent next; None when there is nothing now, or the client is to be given up."""
        while self._line and not self.is_overflowing:
            head = self._line.popleft()
            if isinstance(head, tuple):
                frame, is_status = head
                self._control_bytes -= len(frame)
                self._statuses -= is_status
                return frame
            head.places -= 1
            # One large message may have pushed out several.
            if head.waiting:
                batch, index = head.waiting.popleft()
                self._topic_bytes -= len(batch.payloads[index])
                return Due(head, batch, index)
        return None
