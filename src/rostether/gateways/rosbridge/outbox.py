"""The queues of one client: responses first, then the messages of its topics in turn.

If a topic is too fast for the client, its oldest messages are dropped and counted. A client that does not
read its responses is disconnected. Messages are encoded when they are sent, so a dropped one costs nothing.
"""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Generic, Protocol, TypeAlias, TypeVar

from msgspec import Struct

from rostether.gateways.shared_subscriptions import Batch
from rostether.gateways.websocket.topic_queues import TopicQueues

Frame: TypeAlias = str | bytes

# The limit of waiting statuses; a client that causes more than it reads misses some.
MAX_STATUSES = 100


class Receiver(Protocol):
    """A subscription of the client; `dropped_count` are its messages that were lost."""

    dropped_count: int


ReceiverT = TypeVar("ReceiverT", bound=Receiver)


class Due(Struct, Generic[ReceiverT], frozen=True):
    """One message to send now: the payload of `batch` at `index`."""

    receiver: ReceiverT
    batch: Batch
    index: int


class Outbox(Generic[ReceiverT]):
    """The bounded queues of one client."""

    def __init__(self, max_topic_bytes: int, max_control_bytes: int) -> None:
        # Whether the client has too many unread responses; then nothing more is sent.
        self.is_overflowing = False
        self._max_control_bytes = max_control_bytes
        self._control_bytes = 0
        self._statuses = 0
        self._answers: deque[tuple[Frame, bool]] = deque()
        self._topics = TopicQueues[ReceiverT, tuple[Batch, int]](max_topic_bytes, _count_drop)
        self._wakeup = asyncio.Event()

    def answer(self, frame: Frame, *, is_status: bool = False) -> None:
        """Queue an answer."""
        if is_status:
            if self._statuses >= MAX_STATUSES:
                return
            self._statuses += 1
        self._wakeup.set()
        if self._control_bytes + len(frame) > self._max_control_bytes and self._control_bytes:
            self.is_overflowing = True
            return
        self._control_bytes += len(frame)
        self._answers.append((frame, is_status))

    def put(self, receiver: ReceiverT, batch: Batch, index: int, max_messages: int) -> None:
        """Queue a topic's message; its oldest beyond `max_messages` are dropped."""
        self._topics.add(receiver, (batch, index), [batch.payloads[index]], max_messages=max_messages)
        self._wakeup.set()

    def discard(self, receiver: ReceiverT) -> None:
        """Discard the waiting messages of a topic."""
        self._topics.forget(receiver)

    async def wait(self) -> None:
        """Wait until there may be something to send."""
        if not (self._answers or self._topics or self.is_overflowing):
            self._wakeup.clear()
            await self._wakeup.wait()

    def next(self) -> Frame | Due[ReceiverT] | None:
        """Return the next message to send; None if there is none, or if the client must be disconnected."""
        if self.is_overflowing:
            return None
        if self._answers:
            frame, is_status = self._answers.popleft()
            self._control_bytes -= len(frame)
            self._statuses -= is_status
            return frame
        if self._topics:
            receiver, (batch, index), _ = self._topics.pop()
            return Due(receiver, batch, index)
        return None


def _count_drop(receiver: Receiver) -> None:
    receiver.dropped_count += 1
