"""The topics of a graph as channels, each with the definition that clients need to decode it.

The definition of an unknown type comes from its publisher. A publisher may also define a known type
differently: then the channel gets a new id, and clients subscribe again.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Sequence

from rostether.errors import RostetherError
from rostether.gateways.foxglove.server_messages import Channel
from rostether.gateways.foxglove.settings import NameFilter
from rostether.gateways.shared_subscriptions import (
    PublisherConnection,
    SharedSubscription,
    SharedSubscriptions,
)
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Snapshot
from rostether.mechanisms.tasks import cancel_all
from rostether.msgdef.interface import ANY_MD5SUM, ANY_TYPE, MessageType
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

# More topics than any graph has; announcing them to a client needs about 20 MB.
MAX_CHANNELS = 20_000

# How many topics the gateway subscribes to at once only to learn their types.
_LEARNED_AT_ONCE = 16

# How long to wait for a publisher's type; then the next topic follows.
_PUBLISHER_WAIT_S = 2.0


class Channels:
    """The channels of one gateway; calls `on_offer` for new channels and `on_end` for removed ones."""

    def __init__(
        self,
        store: TypeStore,
        shared: SharedSubscriptions,
        offered: NameFilter,
        on_offer: Callable[[Sequence[Channel]], None],
        on_end: Callable[[Sequence[Channel]], None],
        report: Callable[[str], None],
    ) -> None:
        self.by_id: dict[int, Channel] = {}
        self._store = store
        self._shared = shared
        self._offered = offered
        self._on_offer = on_offer
        self._on_end = on_end
        self._report = report
        self._by_topic: dict[str, Channel] = {}
        self._names: dict[str, str] = {}
        self._learning: dict[str, asyncio.Task[None]] = {}
        self._learned: set[str] = set()
        self._learning_slots = asyncio.Semaphore(_LEARNED_AT_ONCE)
        self._next_id = 1

    def update(self, snapshot: Snapshot) -> None:
        """Update the channels: each published topic is a channel."""
        listed = {
            info.name: info
            for info in snapshot.topics.values()
            if info.publishers and self._offered.includes(info.name)
        }
        gone = [
            topic
            for topic, known in self._names.items()
            if topic not in listed or listed[topic].type not in (ANY_TYPE, known)
        ]
        for topic in gone:
            del self._names[topic]
            self._learned.discard(topic)
            if task := self._learning.pop(topic, None):
                task.cancel()
        self._end(topic for topic in gone if topic in self._by_topic)
        new: list[Channel] = []
        for info in listed.values():
            if info.name in self._names or info.type == ANY_TYPE or len(self._names) >= MAX_CHANNELS:
                continue
            self._names[info.name] = info.type
            message_type = self.known(info.type)
            if message_type is None:
                self._learning[info.name] = asyncio.ensure_future(self._learn(info.name))
            else:
                new.append(self._add(info.name, message_type))
        if new:
            self._on_offer(new)

    def check_publisher(self, channel: Channel, connection: PublisherConnection) -> None:
        """Handle the type in the connection header of a channel's publisher."""
        actual = connection.type
        if actual.md5sum in (channel.type.md5sum, ANY_MD5SUM) or self.by_id.get(channel.id) is not channel:
            return
        if channel.topic in self._learned:
            # Two publishers disagree: the definition of the first is used while it is connected.
            return
        if not self._is_consistent(actual):
            self._report(
                f"{channel.topic} is published with an unknown definition of {actual.name}, and "
                "its publisher does not send the definition; give its package with --msg-path or "
                "ROS_PACKAGE_PATH"
            )
            return
        self._learned.add(channel.topic)
        self._end([channel.topic])
        self._on_offer([self._add(channel.topic, actual)])

    def known(self, name: str) -> MessageType | None:
        """Return the type of this name, or None without a definition."""
        try:
            return self._store.registry.message_type(short_type(name))
        except RostetherError:
            return None

    async def close(self) -> None:
        """Stop learning types."""
        await cancel_all(*self._learning.values())

    def _add(self, topic: str, message_type: MessageType) -> Channel:
        channel = Channel(self._next_id, topic, message_type)
        self._next_id += 1
        self._by_topic[topic] = self.by_id[channel.id] = channel
        return channel

    def _end(self, topics: Iterable[str]) -> None:
        ended = [self._by_topic.pop(topic) for topic in topics]
        for channel in ended:
            del self.by_id[channel.id]
        if ended:
            self._on_end(ended)

    async def _learn(self, topic: str) -> None:
        """Subscribe until a publisher has sent its definition."""
        actual: asyncio.Future[MessageType] = asyncio.get_running_loop().create_future()

        def on_connection(connection: PublisherConnection) -> None:
            if not actual.done():
                actual.set_result(connection.type)

        share: SharedSubscription | None = None
        try:
            async with self._learning_slots:
                share = await self._shared.subscribe(topic, lambda _: None, on_connection)
                await asyncio.wait([actual], timeout=_PUBLISHER_WAIT_S)
            # Without a publisher, no message can arrive either.
            message_type = await actual
        except RostetherError as error:
            self._report(f"{topic} cannot be shown: {error}")
            return
        finally:
            if share is not None:
                await share.close()
        if self._is_consistent(message_type):
            self._learned.add(topic)
            self._on_offer([self._add(topic, message_type)])
        else:
            self._report(
                f"{topic} cannot be shown: its type {self._names[topic]} is not known, and its publisher "
                "does not define it; give its package with --msg-path or ROS_PACKAGE_PATH"
            )
        self._learning.pop(topic, None)

    def _is_consistent(self, actual: MessageType) -> bool:
        if not actual.definition.strip():
            return False
        try:
            learned = Registry.of_full_text(actual.name, actual.definition)
            # Clients decode with this text; a text that differs from the data would show wrong values.
            return learned.message_type(actual.name).md5sum == actual.md5sum
        except RostetherError:
            return False
