"""One topic that a client publishes."""

from __future__ import annotations

import asyncio

from rostether.gateways.new_topic import DRAIN_S, wait_for_subscribers
from rostether.graph.ports import Graph, Publisher

# The limit of stored ids of one topic; above it, the oldest is forgotten. Pages may advertise each message.
MAX_IDS = 100

# The limit of messages that wait for subscribers; above it, they are published immediately.
MAX_FIRST_BYTES = 4 << 20


class ClientPublication:
    """A publisher that keeps a client's first messages until the subscribers of the topic are connected.

    Web pages publish immediately after they advertise, and would lose their first message.
    """

    def __init__(self, graph: Graph, publisher: Publisher, *, is_latching: bool) -> None:
        self.topic = publisher.topic
        self.type = publisher.type
        self.is_latching = is_latching
        self._publisher = publisher
        self._ids: dict[object, None] = {}
        self._first: list[bytes] | None = []
        self._first_bytes = 0
        self._opening = asyncio.ensure_future(self._open(graph))

    def add_id(self, request_id: object) -> None:
        """Add the id of an `advertise`: each object of a page advertises and unadvertises on its own."""
        self._ids[request_id] = None
        if len(self._ids) > MAX_IDS:
            del self._ids[next(iter(self._ids))]

    def remove_id(self, request_id: object) -> bool:
        """Remove an id, or all of them for None; return whether any is left."""
        if request_id is None:
            self._ids.clear()
        self._ids.pop(request_id, None)
        return bool(self._ids)

    async def publish(self, payload: bytes) -> None:
        """Publish; if a subscriber is slow, wait for it, but at most `DRAIN_S`."""
        if self._first is not None:
            self._first.append(payload)
            self._first_bytes += len(payload)
            if self._first_bytes > MAX_FIRST_BYTES:
                self._publish_first()
            return
        if not self._publisher.publish_raw([payload]):
            await self._publisher.drained(DRAIN_S)

    async def close(self) -> None:
        """Publish the waiting messages, and unadvertise. Idempotent."""
        self._opening.cancel()
        self._publish_first()
        await self._publisher.close()

    async def _open(self, graph: Graph) -> None:
        try:
            await wait_for_subscribers(graph, self._publisher)
        finally:
            self._publish_first()

    def _publish_first(self) -> None:
        first, self._first = self._first, None
        if first:
            self._publisher.publish_raw(first)
