"""A bounded queue of messages from an executor's thread to the event loop: one wake-up for many messages."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence

from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES


class Mailbox:
    """A queue from one thread to the event loop, bounded in bytes; a full queue drops the oldest messages.

    `wake` is called in the thread when the first message is put into the empty queue; it must make the loop
    call `pop_all`.
    """

    def __init__(self, wake: Callable[[], None], max_bytes: int = DEFAULT_QUEUE_BYTES) -> None:
        self._wake = wake
        self._max_bytes = max_bytes
        self._lock = threading.Lock()
        self._messages: deque[bytes] = deque()
        self._size_bytes = 0
        self._is_awake = False
        self._is_paused = False
        self.dropped_count = 0

    def put(self, messages: Sequence[bytes]) -> None:
        """Add messages, in the thread."""
        with self._lock:
            self._messages.extend(messages)
            self._size_bytes += sum(map(len, messages))
            while self._size_bytes > self._max_bytes and len(self._messages) > 1:
                self._size_bytes -= len(self._messages.popleft())
                self.dropped_count += 1
            is_news = not self._is_awake and not self._is_paused
            self._is_awake = self._is_awake or is_news
        if is_news:
            self._wake()

    def pop_all(self) -> list[bytes]:
        """Return the messages, oldest first, in the event loop; none while it is paused."""
        with self._lock:
            self._is_awake = False
            if self._is_paused:
                return []
            messages = list(self._messages)
            self._messages.clear()
            self._size_bytes = 0
        return messages

    def pause(self) -> None:
        """Keep new messages in the queue."""
        with self._lock:
            self._is_paused = True

    def resume(self) -> None:
        """Continue; call `pop_all` for messages that arrived in the meantime."""
        with self._lock:
            self._is_paused = False
