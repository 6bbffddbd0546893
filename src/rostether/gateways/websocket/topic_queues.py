"""Messages that wait for a client that reads slowly: bounded in bytes, and fair to its topics."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

# The overhead of a waiting message, so that the limit also applies to many empty messages.
MESSAGE_COST_BYTES = 100

# How much one topic may send in its turn: many small messages pass between two images, not only one.
TURN_BYTES = 64 << 10

# Full queues shrink to this share, so that not every message causes a search for the fullest topic.
_SHRUNK_TO = 0.9

TopicT = TypeVar("TopicT")
TagT = TypeVar("TagT")


class TopicQueues(Generic[TopicT, TagT]):
    """One queue for each topic; when all together exceed `max_bytes`, the fullest loses its oldest messages.

    A topic is any hashable key, and every message has a tag and a payload. `on_drop` is called with the
    topic for each message that is lost.
    """

    def __init__(self, max_bytes: int, on_drop: Callable[[TopicT], None]) -> None:
        self._max_bytes = max_bytes
        self._on_drop = on_drop
        self._bytes = 0
        # Dictionaries keep their order: the first topic is served next. Each message has its time.
        self._queues: dict[TopicT, deque[tuple[TagT, bytes, float]]] = {}
        self._sizes: dict[TopicT, int] = {}
        # The data that the first topic has sent in its turn.
        self._turn_bytes = 0

    def __bool__(self) -> bool:
        return bool(self._queues)

    def add(
        self,
        topic: TopicT,
        tag: TagT,
        payloads: Sequence[bytes],
        now_s: float = 0.0,
        *,
        max_messages: int | None = None,
        max_age_s: float | None = None,
    ) -> None:
        """Queue messages; beyond `max_messages` of the topic, its oldest are dropped.

        If the topic has more than `TURN_BYTES`, messages that have waited longer than `max_age_s` are dropped
        too, but not the newest.
        """
        queue = self._queues.get(topic)
        if queue is None:
            queue = self._queues[topic] = deque()
            self._sizes[topic] = 0
        size = sum(map(len, payloads)) + MESSAGE_COST_BYTES * len(payloads)
        queue.extend([(tag, payload, now_s) for payload in payloads])
        self._sizes[topic] += size
        self._bytes += size
        while max_messages is not None and len(queue) > max_messages:
            self._drop_oldest(topic)
        if max_age_s is not None:
            oldest_s = now_s - max_age_s
            while len(queue) > 1 and self._sizes[topic] > TURN_BYTES and queue[0][2] < oldest_s:
                self._drop_oldest(topic)
        if self._bytes > self._max_bytes:
            self._shrink()

    def forget(self, topic: TopicT) -> None:
        """Discard the messages of a topic that is no longer subscribed."""
        if self._queues.pop(topic, None) is not None:
            self._bytes -= self._sizes.pop(topic)

    def pop(self) -> tuple[TopicT, TagT, bytes]:
        """Return the next topic, tag and payload; topics take turns."""
        topic, queue = next(iter(self._queues.items()))
        tag, payload, _ = queue.popleft()
        cost = len(payload) + MESSAGE_COST_BYTES
        self._bytes -= cost
        self._sizes[topic] -= cost
        self._turn_bytes += cost
        if not queue or self._turn_bytes >= TURN_BYTES:
            self._turn_bytes = 0
            del self._queues[topic]
            if queue:
                self._queues[topic] = queue
            else:
                del self._sizes[topic]
        return topic, tag, payload

    def _shrink(self) -> None:
        limit = int(self._max_bytes * _SHRUNK_TO)
        while self._bytes > limit:
            fullest = max(self._sizes, key=self._sizes.__getitem__)
            if len(self._queues[fullest]) == 1 and len(self._queues) == 1:
                # A single message may exceed the limit; otherwise it would never arrive.
                return
            self._drop_oldest(fullest)

    def _drop_oldest(self, topic: TopicT) -> None:
        queue = self._queues[topic]
        cost = len(queue.popleft()[1]) + MESSAGE_COST_BYTES
        self._bytes -= cost
        self._sizes[topic] -= cost
        if not queue:
            del self._queues[topic], self._sizes[topic]
        self._on_drop(topic)
