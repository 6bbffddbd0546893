"""Messages that wait for a client that reads slowly: bounded in bytes, and fair to its topics."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

MESSAGE_COST_BYTES = 100
"""What a waiting message takes beside its payload, so that a flood of empty ones is bounded too."""

_LOWERED_TO = 0.9
"""When it is full it is lowered to this, so that the fullest topic is not looked for at each message."""


class WaitingMessages:
    """A queue for each subscription; when all are too large together, the fullest loses its oldest ones."""

    def __init__(self, max_bytes: int) -> None:
        self.dropped_count = 0
        self._max_bytes = max_bytes
        self._bytes = 0
        # Dictionaries keep their order: the first is served next.
        self._queues: dict[int, deque[tuple[int, bytes]]] = {}
        self._sizes: dict[int, int] = {}

    def __bool__(self) -> bool:
        return bool(self._queues)

    def add(self, subscription_id: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Let messages wait."""
        queue = self._queues.get(subscription_id)
        if queue is None:
            queue = self._queues[subscription_id] = deque()
            self._sizes[subscription_id] = 0
        size = sum(map(len, payloads)) + MESSAGE_COST_BYTES * len(payloads)
        queue.extend([(time_ns, payload) for payload in payloads])
        self._sizes[subscription_id] += size
        self._bytes += size
        if self._bytes > self._max_bytes:
            self._lower()

    def forget(self, subscription_id: int) -> None:
        """Drop what waits for a subscription that has ended."""
        if self._queues.pop(subscription_id, None) is not None:
            self._bytes -= self._sizes.pop(subscription_id)

    def pop(self) -> tuple[int, int, bytes]:
        """Return the next (subscription id, time, payload): one of each subscription in turn."""
        subscription_id = next(iter(self._queues))
        queue = self._queues.pop(subscription_id)
        time_ns, payload = queue.popleft()
        cost = len(payload) + MESSAGE_COST_BYTES
        self._bytes -= cost
        if queue:
            self._queues[subscription_id] = queue
            self._sizes[subscription_id] -= cost
        else:
            del self._sizes[subscription_id]
        return subscription_id, time_ns, payload

    def _lower(self) -> None:
        limit = int(self._max_bytes * _LOWERED_TO)
        while self._bytes > limit and self._queues:
            fullest = max(self._sizes, key=self._sizes.__getitem__)
            queue = self._queues[fullest]
            if len(queue) == 1 and len(self._queues) == 1:
                # One message larger than all the room there is: still better than none.
                return
            cost = len(queue.popleft()[1]) + MESSAGE_COST_BYTES
            self._bytes -= cost
            self._sizes[fullest] -= cost
            self.dropped_count += 1
            if not queue:
                del self._queues[fullest], self._sizes[fullest]
