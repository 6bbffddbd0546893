"""The topic handles of a device."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Callable, Generator, Iterable, Mapping
from typing import Any, Generic, ParamSpec, Self, TypeAlias, TypeVar, cast, overload

from rostether.device.line import DeviceLine
from rostether.errors import SerializationError
from rostether.rostime import Time
from rostether.serde.codec import Codec
from rostether.serde.values import Message

Fields: TypeAlias = Message | Mapping[str, Any]
OnMessage: TypeAlias = Callable[[Any], object]

P = ParamSpec("P")
M = TypeVar("M", bound=Message)

_LOG = logging.getLogger(__name__)


class Declared:
    """A device's handle. It can be awaited like a graph's handle, so that programs work with both."""

    def __await__(self) -> Generator[None, None, Self]:
        """Return the handle immediately."""
        yield from ()
        return self


class Publisher(Declared, Generic[P]):
    """Sends messages of one topic to the host; `Device.publisher` returns it. `P`: the type's fields."""

    def __init__(
        self, topic: str, topic_id: int, codec: Codec, line: DeviceLine, now: Callable[[], Time]
    ) -> None:
        self.topic = topic
        self._now = now
        self._topic_id = topic_id
        self._codec = codec
        self._line = line

    @property
    def message_class(self) -> type[Message]:
        """The class of the topic's messages; publishing one object repeatedly is the fastest way."""
        return self._codec.message_class

    @overload
    def publish(self, message: object, /) -> bool: ...
    @overload
    def publish(self, *args: P.args, **fields: P.kwargs) -> bool: ...
    # `P.args` is empty: messages take their fields by name.
    def publish(self, message: object = None, /, **fields: Any) -> bool:  # type: ignore[misc]
        """Send one message, given as a message, by its fields, or as the value of its only field.

        Returns False if no host is connected or the line is full. A time may be "now" or seconds. Raises
        SerializationError with the name of a field that does not fit, LocalProtocolError if the message
        exceeds the buffer.
        """
        return self._line.publish(self._topic_id, [self._codec.encode_given(message, fields, now=self._now)])

    def publish_many(self, messages: Iterable[Fields]) -> bool:
        """Send several messages, all or none; faster than one by one. Raises the same errors as `publish`."""
        return self._line.publish(self._topic_id, [self._codec.encode(message) for message in messages])

    async def drained(self, timeout_s: float) -> None:
        """Wait until the line accepts more data; for programs that publish as fast as possible."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                await self._line.wait_writable()
                await asyncio.sleep(0)


class Subscriber(Declared):
    """Receives messages of one topic from the host; `Device.subscriber` returns it."""

    def __init__(self, topic: str, codec: Codec, callback: OnMessage) -> None:
        self.topic = topic
        self.received_count = 0
        self._codec = codec
        self._callback = callback

    def receive(self, payloads: Iterable[bytes]) -> None:
        """Decode payloads and call the callback; payloads that do not fit the type are dropped."""
        for payload in payloads:
            try:
                message = self._codec.decode(payload)
            except SerializationError as error:
                _LOG.debug("dropped a message on %s: %s", self.topic, error)
                continue
            self.received_count += 1
            try:
                self._callback(message)
            except Exception:  # noqa: BLE001 - the program's own code may raise anything
                _LOG.exception("the callback of %s failed", self.topic)


class Messages(Generic[M]):
    """The messages of one topic, to loop over; `Device.messages` returns it.

    The loop ends when the device is closed. The queue is bounded: if the loop is too slow, the oldest
    messages are dropped (`dropped_count`).
    """

    def __init__(self, topic: str, queue_size: int) -> None:
        self.topic = topic
        self.dropped_count = 0
        self._waiting: deque[Message] = deque(maxlen=max(queue_size, 1))
        self._wakeup = asyncio.Event()
        self._has_ended = False

    def put(self, message: Message) -> None:
        """Add a message that arrived."""
        self.dropped_count += len(self._waiting) == self._waiting.maxlen
        self._waiting.append(message)
        self._wakeup.set()

    def begin(self) -> None:
        """Let loops wait for messages again, because the device was opened."""
        self._has_ended = False

    def end(self) -> None:
        """End the loop after the messages that have arrived, because the device was closed."""
        self._has_ended = True
        self._wakeup.set()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> M:
        """Wait for the next message and return it."""
        while not self._waiting:
            if self._has_ended:
                raise StopAsyncIteration
            self._wakeup.clear()
            await self._wakeup.wait()
        return cast("M", self._waiting.popleft())
