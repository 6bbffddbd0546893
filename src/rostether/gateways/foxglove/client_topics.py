"""A topic that a client publishes on the graph."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable

from rostether.errors import RostetherError, UnknownTypeError
from rostether.gateways.foxglove.client_messages import ClientChannel
from rostether.gateways.foxglove.encoding import MAX_QUICK_JSON_BYTES, Encoder
from rostether.gateways.new_topic import DRAIN_S, wait_for_subscribers
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore

# The limit of messages that wait until a topic is advertised: a second of a flood, or two large images.
_MAX_EARLY_MESSAGES = 10_000
_MAX_EARLY_BYTES = 32 << 20

# The limit of different errors per topic; each is reported once.
MAX_REPORTED_ERRORS = 20


class ClientTopic:
    """One channel of one client, which it advertises; `report` gets a line for each kind of error, once."""

    def __init__(
        self, channel: ClientChannel, graph: Graph, store: TypeStore, report: Callable[[str], None]
    ) -> None:
        self.channel = channel
        self._report_once = report_once(report)
        self._publisher: Publisher | None = None
        self._encoder: Encoder | None = None
        self._early: deque[bytes] = deque()
        self._early_bytes = 0
        self._opening = asyncio.ensure_future(self._open(graph, store))

    def publish(self, payload: bytes) -> Awaitable[object] | None:
        """Publish a message; return what the client must await before its next message, None if nothing."""
        if not self._opening.done():
            self._keep(payload)
            # The task is shared: only the wait for it may be canceled.
            return asyncio.wait([self._opening]) if len(payload) > MAX_QUICK_JSON_BYTES else None
        publisher, encoder = self._publisher, self._encoder
        if publisher is None or encoder is None:
            return None
        if encoder.is_slow(payload):
            self._keep(payload)
            self._opening = asyncio.ensure_future(self._publish_kept(publisher, encoder))
            return asyncio.wait([self._opening])
        try:
            message = encoder.encode(payload)
        except RostetherError as error:
            self._report_unpublished(error)
            return None
        return None if publisher.publish_raw([message]) else publisher.drained(DRAIN_S)

    async def close(self) -> None:
        """Unadvertise."""
        await asyncio.wait([self._opening])
        if self._publisher is not None:
            publisher, self._publisher = self._publisher, None
            await publisher.drained(DRAIN_S)
            await publisher.close()

    async def _open(self, graph: Graph, store: TypeStore) -> None:
        try:
            codec, message_type = await types_of(self.channel, store)
            encoder = Encoder.of(self.channel.encoding, codec)
            publisher = await graph.advertise(self.channel.topic, message_type)
        except RostetherError as error:
            self._report_once(f"{self.channel.topic[:200]} cannot be published: {error}")
            self._early.clear()
            return
        try:
            await wait_for_subscribers(graph, publisher)
        finally:
            self._publisher, self._encoder = publisher, encoder
        # A client may send one message and disconnect immediately; its message is also published.
        await self._publish_kept(publisher, encoder)

    async def _publish_kept(self, publisher: Publisher, encoder: Encoder) -> None:
        while self._early:
            payload = self._early.popleft()
            self._early_bytes -= len(payload)
            try:
                publisher.publish_raw([await encoder.convert(payload)])
            except RostetherError as error:
                self._report_unpublished(error)
            await asyncio.sleep(0)

    def _report_unpublished(self, error: RostetherError) -> None:
        self._report_once(f"a message on {self.channel.topic} is not published: {error}")

    def _keep(self, payload: bytes) -> None:
        if len(self._early) >= _MAX_EARLY_MESSAGES or self._early_bytes + len(payload) > _MAX_EARLY_BYTES:
            self._report_once(f"{self.channel.topic[:200]} is not advertised yet; some messages were dropped")
            return
        self._early_bytes += len(payload)
        self._early.append(payload)


def report_once(report: Callable[[str], None]) -> Callable[[str], None]:
    """Return a function that reports each text once, and at most `MAX_REPORTED_ERRORS` texts."""
    reported: set[str] = set()

    def report_new(text: str) -> None:
        if text not in reported and len(reported) < MAX_REPORTED_ERRORS:
            reported.add(text)
            report(text)

    return report_new


async def types_of(channel: ClientChannel, store: TypeStore) -> tuple[Codec, MessageType]:
    """Return the type of a channel: the known definition, else the client's.

    Raises UnknownTypeError, DefinitionError.
    """
    type_name = short_type(channel.schema_name)
    try:
        store.registry.message(type_name)
    except UnknownTypeError:
        if not channel.definition:
            raise
        # Compiling 4,000 fields takes 200 ms.
        return await asyncio.to_thread(_defined, type_name, channel.definition)
    return store.codec(type_name), store.registry.message_type(type_name)


def _defined(type_name: str, definition: str) -> tuple[Codec, MessageType]:
    store = TypeStore(Registry.of_full_text(type_name, definition))
    return store.codec(type_name), store.registry.message_type(type_name)
