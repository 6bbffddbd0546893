"""The handles of a `TypedGraph`: what publishes and receives messages as values."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from contextlib import aclosing
from typing import Any, Generic, ParamSpec, TypeAlias, overload

from rostether.errors import RostetherError, UnknownTypeError
from rostether.graph.message_stream import MessageStream
from rostether.graph.ports import Publisher
from rostether.rostime import Time
from rostether.serde.codec import Codec
from rostether.serde.values import Message

P = ParamSpec("P")

MessageLike: TypeAlias = Message | Mapping[str, Any]

_SUBSCRIBER_POLL_S = 0.01

_LOG = logging.getLogger(__name__)


def name_of_type(given: str | Callable[..., Message]) -> str:
    """Return the name of a type that is given by name or as a message class."""
    if isinstance(given, str):
        return given
    name: str = getattr(given, "_type", "")
    if not name:
        raise UnknownTypeError(f"{given!r} is not a message type; write its name, such as std_msgs/String")
    return name


class TypedPublisher(Generic[P]):
    """Publishes messages of one type; made by `TypedGraph.publisher`. `P` are the type's fields."""

    def __init__(self, publisher: Publisher, codec: Codec, now: Callable[[], Time]) -> None:
        self.raw = publisher
        self.codec = codec
        self._now = now

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self.raw.topic

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return self.raw.subscriber_count

    @overload
    def publish(self, message: object, /) -> bool: ...
    @overload
    def publish(self, *args: P.args, **fields: P.kwargs) -> bool: ...
    # `P.args` is empty: messages take their fields by name.
    def publish(self, message: object = None, /, **fields: Any) -> bool:  # type: ignore[misc]
        """Publish one message, given whole, by its fields, or as the value of its only field.

        A time may be "now" or seconds. False asks a flooding caller to await `drained`.
        Raises SerializationError naming the field that does not fit.
        """
        value = fields if message is None else self.codec.fields_of(message)
        return self.raw.publish_raw([self.codec.encode(value, now=self._now)])

    async def drained(self, timeout_s: float) -> None:
        """Wait until no subscriber is above its high-water mark."""
        await self.raw.drained(timeout_s)

    async def wait_for_subscriber(self, timeout_s: float | None = None) -> bool:
        """Wait for a subscriber; returns False if none subscribed in time."""
        try:
            async with asyncio.timeout(timeout_s):
                # The port announces no connections; looking is cheap.
                while not self.raw.subscriber_count:  # noqa: ASYNC110
                    await asyncio.sleep(_SUBSCRIBER_POLL_S)
        except TimeoutError:
            return False
        return True

    async def close(self) -> None:
        """Unadvertise. Idempotent."""
        await self.raw.close()


class CallbackSubscriber:
    """Calls back with the messages of a topic until it is closed; made by `TypedGraph.subscriber`."""

    def __init__(self, stream: MessageStream[Any], callback: Callable[[Any], object]) -> None:
        self.topic = stream.topic
        self._stream = stream
        self._callback = callback
        self._task = asyncio.create_task(self._listen())

    async def _listen(self) -> None:
        try:
            async with aclosing(aiter(self._stream)) as messages:
                async for message in messages:
                    try:
                        self._callback(message)
                    except Exception:  # noqa: BLE001 - it is the user's code
                        # One bad message must not end the subscription.
                        _LOG.exception("the callback for %s failed", self.topic)
        except RostetherError as error:
            _LOG.error("the subscription of %s ended: %s", self.topic, error)

    async def close(self) -> None:
        """Unsubscribe. Idempotent."""
        self._task.cancel()
        await asyncio.wait([self._task])
