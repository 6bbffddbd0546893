"""One topic that a client publishes."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from rostether.gateways.new_topic import DRAIN_S, wait_for_subscribers
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.interface import MessageType

# The limit of messages that wait for subscribers; above it, they are published immediately.
MAX_FIRST_BYTES = 4 << 20


class ClientPublication:
    """A publisher that keeps a client's first messages until the subscribers of the topic are connected.

    Web pages publish immediately after they advertise, and would lose their first message.
    """

    def __init__(self, publisher: Publisher, *, is_latching: bool = False) -> None:
        self.topic = publisher.topic
        self.type = publisher.type
        self.is_latching = is_latching
        self._publisher = publisher
        self._first: list[bytes] | None = []
        self._first_bytes = 0
        self._opening: asyncio.Task[None] | None = None

    @classmethod
    async def open(
        cls, graph: Graph, topic: str, message_type: MessageType, *, latch: bool
    ) -> ClientPublication:
        """Advertise. Raises InvalidNameError, GraphError."""
        publication = cls(await graph.advertise(topic, message_type, latch=latch), is_latching=latch)
        publication._opening = asyncio.ensure_future(publication._open(graph))
        return publication

    async def publish(self, payloads: Sequence[bytes]) -> None:
        """Publish; if a subscriber is slow, wait for it, but at most `DRAIN_S`."""
        if self._first is not None:
            self._first += payloads
            self._first_bytes += sum(map(len, payloads))
            if self._first_bytes > MAX_FIRST_BYTES:
                self._publish_first()
            return
        if not self._publisher.publish_raw(payloads):
            await self._publisher.drained(DRAIN_S)

    async def close(self) -> None:
        """Publish the waiting messages, and unadvertise. Idempotent."""
        if self._opening is not None:
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
