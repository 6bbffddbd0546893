"""Relays one topic from one graph to the other, with the publisher's type and raw messages."""

from __future__ import annotations

import asyncio
from collections.abc import Container, Mapping, Sequence

from rostether.graph.ports import Publisher, Subscriber
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.relay.side import Side

# How long a slow subscriber on the other side may delay the others, as in the bridge to boards.
PAUSE_S = 0.1


class TopicRelay:
    """Relays a topic until it is closed; messages of `skip_nodes` are left out."""

    def __init__(self, topic: str, source: Side, target: Side, skip_nodes: Container[str] = ()) -> None:
        self.topic = topic
        self.source = source
        self.target = target
        self.type: MessageType | None = None
        self.message_count = 0
        self._skip_nodes = skip_nodes
        self._publisher: Publisher | None = None
        self._subscriber: Subscriber | None = None
        self._pausing: asyncio.Task[None] | None = None
        self._is_closed = False

    async def open(self) -> None:
        """Wait for a publisher, then relay its type and messages. Raises RostetherError."""
        self.type, is_latched = await self._learn()
        publisher = await self.target.graph.advertise(self.topic, self.type, latch=is_latched)
        if self._is_closed:
            await publisher.close()
            return
        self._publisher = publisher
        subscriber = await self.source.graph.subscribe(
            self.topic, self.type, self._take, skip_own=True, skip_nodes=self._skip_nodes
        )
        if self._is_closed:
            await subscriber.close()
            return
        self._subscriber = subscriber

    async def close(self) -> None:
        """Stop. Idempotent. Raises GraphError."""
        self._is_closed = True
        if self._pausing is not None:
            self._pausing.cancel()
        subscriber, self._subscriber = self._subscriber, None
        publisher, self._publisher = self._publisher, None
        try:
            if subscriber is not None:
                await subscriber.close()
        finally:
            if publisher is not None:
                await publisher.close()

    async def _learn(self) -> tuple[MessageType, bool]:
        """Return the type of the first publisher, and whether it latches."""
        met: asyncio.Future[Mapping[str, str]] = asyncio.get_running_loop().create_future()

        def meet(fields: Mapping[str, str]) -> None:
            if not met.done() and fields.get("callerid", "") not in self._skip_nodes:
                met.set_result(fields)

        # Everything except the connection header comes again with the subscription to its type.
        subscriber = await self.source.graph.subscribe(
            self.topic, ANY_MESSAGE, lambda _: None, on_connection=meet, skip_own=True
        )
        try:
            fields = await met
        finally:
            await subscriber.close()
        message_type = MessageType(fields["type"], fields["md5sum"], fields.get("message_definition", ""))
        return message_type, fields.get("latching") == "1"

    def _take(self, payloads: Sequence[bytes]) -> None:
        if self._publisher is None:
            return
        self.message_count += len(payloads)
        if not self._publisher.publish_raw(payloads) and self._pausing is None:
            self._pausing = asyncio.get_running_loop().create_task(self._pause())

    async def _pause(self) -> None:
        publisher, subscriber = self._publisher, self._subscriber
        try:
            if publisher is not None and subscriber is not None:
                subscriber.pause()
                await publisher.drained(PAUSE_S)
        finally:
            self._pausing = None
            if subscriber is not None:
                subscriber.resume()
