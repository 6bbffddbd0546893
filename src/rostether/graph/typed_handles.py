"""The handles of a `TypedGraph`, which publish and receive messages as values."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import aclosing
from typing import Any, Generic, ParamSpec, TypeAlias, TypeVar, cast, overload

from rostether.errors import GraphError, RostetherError
from rostether.graph.message_stream import MessageStream
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.interface import ServiceType
from rostether.serde.codec import Codec
from rostether.serde.values import Message

P = ParamSpec("P")
Response = TypeVar("Response", bound=Message)

MessageLike: TypeAlias = Message | Mapping[str, Any]

# Users do not notice a wait of this length.
_SUBSCRIBER_POLL_S = 0.01

_LOG = logging.getLogger(__name__)


class TypedPublisher(Generic[P]):
    """Publishes messages of one type; made by `TypedGraph.publisher`. `P` are the type's fields."""

    def __init__(self, publisher: Publisher, codec: Codec, graph: Graph) -> None:
        self.raw = publisher
        self.codec = codec
        self._graph = graph
        self._is_closed = False

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
        """Publish one message, given as a message, by its fields, or as the value of its only field.

        A time may be "now" or seconds. Returns False if a subscriber is too slow: then await `drained` before
        you publish more. Raises SerializationError with the name of a field that does not fit.
        """
        return self.raw.publish_raw([self.codec.encode_given(message, fields, now=self._graph.now)])

    async def drained(self, timeout_s: float) -> None:
        """Wait until all subscribers have read enough, at most `timeout_s`."""
        await self.raw.drained(timeout_s)

    async def wait_for_subscriber(self, timeout_s: float | None = None) -> bool:
        """Wait for a subscriber; return False if none subscribed in time.

        Raises GraphError if the publisher is closed, or its node leaves the graph.
        """
        leaving = asyncio.ensure_future(self._graph.wait_closed())
        try:
            async with asyncio.timeout(timeout_s):
                # The port does not report connections; a check is cheap.
                while not self.raw.subscriber_count:
                    if self._is_closed or leaving.done():
                        raise GraphError(f"the publisher of {self.topic} was closed")
                    await asyncio.sleep(_SUBSCRIBER_POLL_S)
        except TimeoutError:
            return False
        finally:
            leaving.cancel()
        return True

    async def close(self) -> None:
        """Unadvertise. Idempotent."""
        self._is_closed = True
        await self.raw.close()


class CallbackSubscriber:
    """Calls a function with each message of a topic until it is closed; made by `TypedGraph.subscriber`."""

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
                        answer = self._callback(message)
                        if isinstance(answer, Awaitable):
                            await answer
                    except Exception:  # noqa: BLE001 - it is the user's code
                        # One bad message must not end the subscription.
                        _LOG.exception("the callback for %s failed", self.topic)
        except RostetherError as error:
            _LOG.error("the subscription of %s ended: %s", self.topic, error)

    async def close(self) -> None:
        """Unsubscribe. Idempotent."""
        self._task.cancel()
        await asyncio.wait([self._task])


class TypedServiceClient(Generic[Response]):
    """Calls a service; made by `TypedGraph.service_client`."""

    def __init__(
        self, graph: Graph, service: str, service_type: ServiceType, codecs: tuple[Codec, Codec]
    ) -> None:
        self.service = service
        self._graph = graph
        self._service_type = service_type
        self._request_codec, self._response_codec = codecs

    async def call(
        self, request: MessageLike | None = None, /, *, timeout_s: float | None = None, **fields: Any
    ) -> Response:
        """Call the service and return its response; pass the whole request, or its fields.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        InvalidNameError, SerializationError.
        """
        payload = self._request_codec.encode_given(request, fields)
        answer = await self._graph.call_service(
            self.service, self._service_type, payload, timeout_s=timeout_s
        )
        return cast("Response", self._response_codec.decode(answer))
