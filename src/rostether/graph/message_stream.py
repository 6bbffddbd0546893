"""A topic's messages for a loop, decoded with the definition of their publisher."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import AsyncGenerator, Callable, Mapping, Sequence
from typing import Generic, TypeVar, cast

from rostether.errors import RostetherError, SerializationError, TypeMismatchError, UnknownTypeError
from rostether.graph.ports import Graph
from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.interface import ANY_MD5SUM, ANY_MESSAGE
from rostether.msgdef.registry import Registry
from rostether.msgdef.search_waiting import wait_for_definitions
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

M = TypeVar("M", bound=Message)

_LOG = logging.getLogger(__name__)

# The queue for a busy loop: a second of the fastest sensor, and little memory.
DEFAULT_QUEUE_MESSAGES = 1000

# The same bound for large messages: about ten camera images.
MAX_QUEUE_BYTES = 64 << 20

# Publishers are found within a second; after this time without one, a waiting program gets a log line.
SILENCE_WARNING_S = 5.0

# Definitions come from peers; beyond this number of types, the first is forgotten.
MAX_LEARNED_TYPES = 256


class LearnedTypes:
    """Codecs for the types that publishers declare, even if their definition here differs or is missing."""

    def __init__(self, store: TypeStore) -> None:
        self.store = store
        self._codecs: dict[tuple[str, str], Codec] = {}

    def codec(self, header: Mapping[str, str]) -> Codec:
        """Return the codec for a connection header. Raises DefinitionError, TypeMismatchError."""
        name, md5sum = header.get("type", ""), header.get("md5sum", ANY_MD5SUM)
        found = self._codecs.get((name, md5sum))
        if found is None:
            found = self._find(name, md5sum, header.get("message_definition", ""))
            if len(self._codecs) >= MAX_LEARNED_TYPES:
                del self._codecs[next(iter(self._codecs))]
            self._codecs[name, md5sum] = found
        return found

    def _find(self, name: str, md5sum: str, definition: str) -> Codec:
        registry = self.store.registry
        try:
            # The publisher's definition is as good as a search of folders, which would block the event loop.
            can_ask = not definition or registry.can_answer(lambda: registry.message_type(name))
            known = registry.message_type(name).md5sum if can_ask else ""
        except UnknownTypeError:
            if not definition:
                raise
            known = ""
        if known and md5sum in (known, ANY_MD5SUM):
            return self.store.codec(name)
        if definition:
            # A separate store: here, the same name and its nested types may have other definitions.
            learned = Registry.of_full_text(name, definition)
            return self.store.for_registry(learned).codec(name)
        raise TypeMismatchError(
            f"{name} has md5sum {md5sum} at its publisher and {known} here, and the publisher sends no "
            "definition; give the type's package with --msg-path or ROS_PACKAGE_PATH"
        )


class MessageStream(Generic[M]):
    """The messages of one topic; made by `TypedGraph.messages`.

    A loop subscribes, and unsubscribes when it is left; it ends by itself when the node leaves the graph.
    The queue is bounded, and drops the oldest first. `reports_silence`: a topic without publishers is logged.
    """

    def __init__(
        self,
        graph: Graph,
        types: LearnedTypes,
        topic: str,
        type_name: str | None,
        queue_size: int,
        *,
        reports_silence: bool = False,
    ) -> None:
        self.topic = topic

        # Messages that were dropped because the loop was too slow.
        self.dropped_count = 0
        # Messages that did not have their type's layout.
        self.misfit_count = 0
        # Called with the reason for each of them.
        self.on_misfit: Callable[[SerializationError], None] | None = None
        self._graph = graph
        self._types = types
        self._type_name = type_name
        self._codec: Codec | None = None
        self._queue_size = max(queue_size, 1)
        self._reports_silence = reports_silence
        self._payloads: deque[tuple[Codec, bytes]] = deque()
        self._queued_bytes = 0
        self._wakeup = asyncio.Event()
        self._error: RostetherError | None = None
        self._generator: AsyncGenerator[M, None] | None = None

    @property
    def codec(self) -> Codec | None:
        """The codec that decodes messages; None until the type of the first publisher is known."""
        return self._codec

    async def __aiter__(self) -> AsyncGenerator[M, None]:
        """Subscribe and yield messages.

        Raises UnknownTypeError, DefinitionError, TypeMismatchError, InvalidNameError, GraphError.
        """
        message_type = ANY_MESSAGE
        name, registry = self._type_name, self._types.store.registry
        if name is not None:
            message_type = await wait_for_definitions(registry, lambda: registry.message_type(name))
            self._codec = self._types.store.codec(name)
        subscriber = await self._graph.subscribe(
            self.topic,
            message_type,
            self._queue,
            on_connection=self._learn if self._type_name is None else None,
        )
        leaving = asyncio.ensure_future(self._graph.wait_closed())
        leaving.add_done_callback(lambda _: self._wakeup.set())
        warning = asyncio.ensure_future(self._warn_of_silence()) if self._reports_silence else None
        try:
            while not leaving.done():
                await self._wakeup.wait()
                self._wakeup.clear()
                if warning is not None:
                    warning.cancel()
                while self._payloads:
                    codec, payload = self._payloads.popleft()
                    self._queued_bytes -= len(payload)
                    try:
                        message = codec.decode(payload)
                    except SerializationError as error:
                        self.misfit_count += 1
                        if self.on_misfit is not None:
                            self.on_misfit(error)
                        continue
                    yield cast("M", message)
                if self._error is not None:
                    raise self._error
        finally:
            leaving.cancel()
            if warning is not None:
                warning.cancel()
            await subscriber.close()

    async def __anext__(self) -> M:
        """Return the next message; the first call subscribes, until `aclose`.

        Raises the same errors as the loop.
        """
        if self._generator is None:
            self._generator = self.__aiter__()
        return await anext(self._generator)

    async def aclose(self) -> None:
        """End the subscription that `anext` began. Idempotent."""
        generator, self._generator = self._generator, None
        if generator is not None:
            await generator.aclose()

    async def _warn_of_silence(self) -> None:
        await asyncio.sleep(SILENCE_WARNING_S)
        with contextlib.suppress(RostetherError):
            name, topics = self._graph.resolve(self.topic), (await self._graph.snapshot()).topics
            published = [each for each, topic in topics.items() if topic.publishers]
            if name not in published:
                hint = did_you_mean(name, published)
                _LOG.warning(
                    "waiting for a message of %s, which has no publisher%s", name, hint and f"; {hint}"
                )

    def _learn(self, header: Mapping[str, str]) -> None:
        try:
            self._codec = self._types.codec(header)
        except RostetherError as error:
            self._error = error
            self._wakeup.set()

    def _queue(self, payloads: Sequence[bytes]) -> None:
        codec = self._codec
        if codec is None:
            return
        for payload in payloads:
            self._payloads.append((codec, payload))
            self._queued_bytes += len(payload)
            while len(self._payloads) > self._queue_size or self._queued_bytes > MAX_QUEUE_BYTES:
                self._queued_bytes -= len(self._payloads.popleft()[1])
                self.dropped_count += 1
        self._wakeup.set()
