"""Holds a board's announcements and messages while a thread searches the disk for its types.

Most types are known. The search for an unknown type does not block the event loop. From the announcement of
that type on, announcements and the messages of topics that are not served yet wait here, in their order.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.msgdef.registry import Registry
from rostether.msgdef.search_waiting import start_search
from rostether.rosserial.events import (
    HostEvent,
    MessagesReceived,
    NegotiationSettled,
    ServiceAnnounced,
    ServiceWithdrawn,
    TopicAnnounced,
    TopicWithdrawn,
)

# A search takes 3 s at most on a slow disk; a board sends about 6 KB/s on a serial line.
MAX_HELD_BYTES = 1 << 20
# A board has 256 endpoints at most, and announces each once.
MAX_HELD_EVENTS = 1024

_FOLLOWING = (TopicWithdrawn, ServiceWithdrawn, NegotiationSettled)


class HeldEvents:
    """The events of one connection that wait for a search; then `handle` gets them, or `fail` the error."""

    def __init__(
        self, registry: Registry, handle: Callable[[HostEvent], None], fail: Callable[[Exception], None]
    ) -> None:
        self._registry = registry
        self._handle = handle
        self._fail = fail
        self._events: list[HostEvent] = []
        self._bytes = 0
        self._wait: asyncio.Future[None] | None = None

    @property
    def is_waiting(self) -> bool:
        """Whether a search is in progress."""
        return self._wait is not None

    def hold_back(self, event: HostEvent) -> bool:
        """Keep an announcement whose type needs a search, and later events; return whether it was kept."""
        if isinstance(event, (TopicAnnounced, ServiceAnnounced)):
            if self._wait is None:
                if self._can_answer(event):
                    return False
                self._wait = asyncio.wrap_future(start_search(self._registry))
                self._wait.add_done_callback(self._release)
        elif not isinstance(event, _FOLLOWING):
            return False
        return self.keep(event)

    def keep(self, event: HostEvent) -> bool:
        """Keep an event behind those that wait; False if none waits or there is no room."""
        if self._wait is None:
            return False
        size = sum(map(len, event.payloads)) if isinstance(event, MessagesReceived) else 0
        if len(self._events) >= MAX_HELD_EVENTS or self._bytes + size > MAX_HELD_BYTES:
            return False
        self._events.append(event)
        self._bytes += size
        return True

    def drop(self) -> None:
        """Drop all events: the connection has ended."""
        wait, self._wait = self._wait, None
        self._events.clear()
        if wait is not None:
            wait.cancel()

    def _can_answer(self, event: TopicAnnounced | ServiceAnnounced) -> bool:
        registry = self._registry

        def query() -> None:
            if isinstance(event, TopicAnnounced):
                matches = registry.message_type(event.info.message_type).md5sum == event.info.md5sum
            else:
                known = registry.service_type(event.type)
                announced = event.request.md5sum, event.response.md5sum
                matches = announced == (known.request.md5sum, known.response.md5sum)
            if not matches:
                # The report about a mismatch names the types that match.
                registry.packages()

        return registry.can_answer(query)

    def _release(self, wait: asyncio.Future[None]) -> None:
        if wait is not self._wait:
            return
        self._wait = None
        events, self._events, self._bytes = self._events, [], 0
        try:
            wait.result()
            for event in events:
                self._handle(event)
        except Exception as error:  # noqa: BLE001 - an error caused by one board ends only its session
            self._fail(error)
