"""Relays one topic from one graph to the other, with the publisher's type and raw messages."""

from __future__ import annotations

import asyncio
from collections.abc import Container, Mapping, Sequence

from rostether.graph.ports import Publisher, Subscriber
from rostether.graph.static_transforms import TRANSFORM_TYPES, StaticTransforms
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.relay.side import RelaySide

# How long a slow subscriber on the other side may delay the others, as in the bridge to boards.
PAUSE_S = 0.1

# The time for subscribers on the other side to connect: DDS takes more than a second on a busy machine. A
# graph may also list subscribers that were killed.
CONNECT_S = 3.0

# A graph may list the relay's own subscriber, which does not connect. If all others are connected and none
# was added for this time, the relay does not wait for it.
SETTLE_S = 0.2

# How often connected subscribers are counted; the port does not report them.
_COUNT_INTERVAL_S = 0.01


class TopicRelay:
    """Relays a topic from `open` to `close`; messages of `skip_nodes` are omitted.

    Messages that arrive before the subscribers on the other side are connected wait here. Then the
    subscription pauses, so that further messages wait in the source graph's queues.
    """

    def __init__(self, topic: str, source: RelaySide, target: RelaySide, skip_nodes: Container[str]) -> None:
        self._topic = topic
        self._source = source
        self._target = target
        self._type = ANY_MESSAGE
        self._skip_nodes = skip_nodes
        self._is_latched = False
        self._transforms: StaticTransforms | None = None
        self._type_changed = asyncio.Event()
        self._waiting: list[bytes] = []
        self._publisher: Publisher | None = None
        self._is_ready = False
        self._subscriber: Subscriber | None = None
        self._pausing: asyncio.Task[None] | None = None

    @property
    def type_name(self) -> str:
        """The name of the type, `*` before it is known."""
        return self._type.name

    async def open(self) -> None:
        """Wait for a publisher, then relay its type and messages. Raises RostetherError."""
        self._subscriber = await self._source.graph.subscribe(
            self._topic,
            ANY_MESSAGE,
            self._publish_or_hold,
            on_connection=self._handle_connection,
            skip_own=True,
            skip_nodes=self._skip_nodes,
            one_type=True,
        )
        await self.wait_for_new_type()

    async def wait_for_new_type(self) -> None:
        """Wait for a publisher of a new type, and relay this type. Raises RostetherError."""
        await self._type_changed.wait()
        self._type_changed.clear()
        if self._publisher is not None:
            await self._publisher.close()
        self._publisher = publisher = await self._target.graph.advertise(
            self._topic, self._type, latch=self._is_latched
        )
        await self._subscribers_connected(publisher)
        self._is_ready = not self._type_changed.is_set()
        if self._is_ready:
            waiting, self._waiting = self._waiting, []
            self._publish(waiting)
        if self._subscriber is not None:
            self._subscriber.resume()

    async def close(self) -> None:
        """Stop. Raises GraphError."""
        self._is_ready = False
        if self._pausing is not None:
            self._pausing.cancel()
        try:
            if self._subscriber is not None:
                await self._subscriber.close()
        finally:
            if self._publisher is not None:
                await self._publisher.close()

    def _handle_connection(self, fields: Mapping[str, str]) -> None:
        if fields.get("callerid", "") in self._skip_nodes:
            return
        found = MessageType(fields["type"], fields["md5sum"], fields.get("message_definition", ""))
        is_latched = fields.get("latching") == "1"
        if (found.name, found.md5sum) != (self._type.name, self._type.md5sum):
            # Messages of the old type can no longer be published.
            self._waiting.clear()
        elif self._is_latched or not is_latched:
            return
        self._type, self._is_latched = found, is_latched
        self._transforms = StaticTransforms() if is_latched and found.name in TRANSFORM_TYPES else None
        self._is_ready = False
        self._type_changed.set()

    async def _subscribers_connected(self, publisher: Publisher) -> None:
        """Wait until the subscribers that the other graph lists are connected, at most `CONNECT_S`."""
        graph = self._target.graph
        topic = (await graph.snapshot()).topics.get(publisher.topic)
        listed = set() if topic is None else set(topic.subscribers)
        others = listed - {graph.node_name}
        loop = asyncio.get_running_loop()
        changed_s = loop.time()
        deadline_s, count = changed_s + CONNECT_S, publisher.subscriber_count
        while count < len(listed) and loop.time() < deadline_s:
            if count >= len(others) and loop.time() - changed_s >= SETTLE_S:
                break
            await asyncio.sleep(_COUNT_INTERVAL_S)
            if publisher.subscriber_count != count:
                changed_s, count = loop.time(), publisher.subscriber_count

    def _publish_or_hold(self, payloads: Sequence[bytes]) -> None:
        if self._is_ready:
            self._publish(payloads)
        else:
            self._waiting += payloads
            if self._subscriber is not None:
                self._subscriber.pause()

    def _publish(self, payloads: Sequence[bytes]) -> None:
        if self._publisher is None:
            return
        if self._transforms is not None:
            payloads = [self._transforms.merge(each) for each in payloads]
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
            if subscriber is not None and self._is_ready:
                subscriber.resume()
