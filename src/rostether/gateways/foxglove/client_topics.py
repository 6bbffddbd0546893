"""A topic that a client publishes on the graph."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

from rostether.errors import ConfigError, RostetherError, SerializationError, UnknownTypeError
from rostether.gateways.foxglove.client_messages import ClientChannel
from rostether.gateways.foxglove.json_messages import decode_json
from rostether.gateways.foxglove.server_messages import JSON_ENCODING, ROS1_ENCODING
from rostether.gateways.new_topic import DRAIN_S, wait_for_subscribers
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore

MAX_EARLY_MESSAGES = 10_000

# Messages that a client sends before its topic is advertised: a second of a flood, or two large images.
MAX_EARLY_BYTES = 32 << 20

# The limit of different mistakes per topic; each is reported once.
MAX_REPORTED_MISTAKES = 20


class ClientTopic:
    """One channel of one client; `report` gets a line for each kind of mistake, once."""

    def __init__(self, channel: ClientChannel, report: Callable[[str], None]) -> None:
        self.channel = channel
        self._report = report
        self._publisher: Publisher | None = None
        self._encode: Callable[[bytes], bytes] | None = None
        self._early: deque[bytes] = deque()
        self._early_bytes = 0
        self._reported: set[str] = set()
        self._opening: asyncio.Task[None] | None = None

    def open(self, graph: Graph, store: TypeStore) -> None:
        """Advertise the topic; errors are reported to the client."""
        self._opening = asyncio.ensure_future(self._open(graph, store))

    def publish(self, payload: bytes) -> Publisher | None:
        """Publish a message; returns the publisher when its subscribers cannot keep up, to wait for."""
        if self._publisher is None or self._encode is None:
            self._keep(payload)
            return None
        try:
            message = self._encode(payload)
        except RostetherError as error:
            self._report_once(f"a message on {self.channel.topic} is not published: {error}")
            return None
        return None if self._publisher.publish_raw([message]) else self._publisher

    async def close(self) -> None:
        """Unadvertise."""
        if self._opening is not None:
            await asyncio.wait([self._opening])
        if self._publisher is not None:
            publisher, self._publisher = self._publisher, None
            await publisher.drained(DRAIN_S)
            await publisher.close()

    async def _open(self, graph: Graph, store: TypeStore) -> None:
        try:
            codec, message_type = types_of(self.channel, store)
            self._encode = encoder(self.channel, codec)
            publisher = await graph.advertise(self.channel.topic, message_type)
        except RostetherError as error:
            self._report_once(f"{self.channel.topic[:200]} cannot be published: {error}")
            self._early.clear()
            self._early_bytes = MAX_EARLY_BYTES
            return
        try:
            await wait_for_subscribers(graph, publisher)
        finally:
            self._publisher = publisher
        # A client may send one message and disconnect at once; its message is also published.
        while self._early:
            self.publish(self._early.popleft())

    def _keep(self, payload: bytes) -> None:
        if len(self._early) >= MAX_EARLY_MESSAGES or self._early_bytes + len(payload) > MAX_EARLY_BYTES:
            self._report_once(f"{self.channel.topic[:200]} is not advertised yet; some messages were dropped")
            return
        self._early_bytes += len(payload)
        self._early.append(payload)

    def _report_once(self, text: str) -> None:
        if text not in self._reported and len(self._reported) < MAX_REPORTED_MISTAKES:
            self._reported.add(text)
            self._report(text)


def types_of(channel: ClientChannel, store: TypeStore) -> tuple[Codec, MessageType]:
    """Return the type of a channel: the known definition, else the client's.

    Raises UnknownTypeError, DefinitionError.
    """
    type_name = short_type(channel.schema_name)
    try:
        store.registry.message(type_name)
    except UnknownTypeError:
        if not channel.schema:
            raise
        store = TypeStore(Registry.of_full_text(type_name, channel.schema))
    return store.codec(type_name), store.registry.message_type(type_name)


def encoder(channel: ClientChannel, codec: Codec) -> Callable[[bytes], bytes]:
    """Return a converter of a client's messages that checks them. Raises ConfigError."""
    if channel.encoding == JSON_ENCODING:
        return lambda payload: codec.encode(decode_json(codec, payload))
    if channel.encoding != ROS1_ENCODING:
        raise ConfigError(f"messages are {ROS1_ENCODING} or {JSON_ENCODING}, not {channel.encoding[:40]!r}")
    layout = codec.layout

    def check(payload: bytes) -> bytes:
        if not layout.accepts(payload):
            raise SerializationError(layout.explain(payload))
        return payload

    return check
