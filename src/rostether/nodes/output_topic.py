"""A topic that republishes other topics: it learns its type from their publishers."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Mapping, Sequence

from rostether.errors import RostetherError
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.interface import ANY_TYPE, MessageType

# The number of messages that wait for the advertisement, which takes milliseconds; the same as in
# topic_tools.
MAX_WAITING_MESSAGES = 10

_log = logging.getLogger("rostether.nodes")


class OutputTopic:
    """Publishes under one name with the type and latching of its input."""

    def __init__(self, graph: Graph, topic: str, *, latch: bool | None = None) -> None:
        self.topic = topic
        self._graph = graph
        self._latch = latch
        self._type: MessageType | None = None
        self._publisher: Publisher | None = None
        self._opening: asyncio.Task[None] | None = None
        self._waiting: deque[bytes] = deque(maxlen=MAX_WAITING_MESSAGES)

    @property
    def is_advertised(self) -> bool:
        """Whether the type is known and others can subscribe."""
        return self._publisher is not None

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return self._publisher.subscriber_count if self._publisher is not None else 0

    def advertise_as(self, header: Mapping[str, str]) -> None:
        """Advertise the type in the connection header of an input, again if it has changed."""
        name = header.get("type", ANY_TYPE)
        if name == ANY_TYPE:
            return
        latch = header.get("latching") == "1" if self._latch is None else self._latch
        wanted = MessageType(name, header.get("md5sum", ""), header.get("message_definition", ""))
        if self._type is not None and self._type.md5sum == wanted.md5sum:
            return
        self._type = wanted
        previous = self._opening
        self._opening = asyncio.ensure_future(self._open(wanted, latch, previous))

    def publish(self, payloads: Sequence[bytes]) -> None:
        """Publish, or keep the newest messages until the topic is advertised."""
        if self._publisher is not None:
            self._publisher.publish_raw(payloads)
        else:
            self._waiting.extend(payloads)

    async def close(self) -> None:
        """Unadvertise. Idempotent."""
        if self._opening is not None:
            self._opening.cancel()
            await asyncio.wait([self._opening])
        if self._publisher is not None:
            await self._publisher.close()
            self._publisher = None

    async def _open(self, wanted: MessageType, latch: bool, previous: asyncio.Task[None] | None) -> None:
        if previous is not None:
            await asyncio.wait([previous])
        try:
            if self._publisher is not None:
                await self._publisher.close()
                self._publisher = None
            publisher = await self._graph.advertise(self.topic, wanted, latch=latch)
        except RostetherError as error:
            # The next connection retries.
            self._type = None
            _log.warning("%s is not published: %s", self.topic, error)
            return
        if self._waiting:
            publisher.publish_raw(list(self._waiting))
            self._waiting.clear()
        self._publisher = publisher
