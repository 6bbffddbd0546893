"""Fills a tf buffer from /tf and /tf_static."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from typing import Any

from rostether.errors import RostetherError
from rostether.graph.ports import OnMessages
from rostether.graph.typed_graph import TypedGraph
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_messages import TF_STATIC_TOPIC, TF_TOPIC, TF_TYPE, from_message
from rostether.robot.transform import StampedTransform

# tf2's name for a publisher that sends no name.
UNKNOWN_AUTHORITY = "unknown_publisher"

# Gets the transforms of a message, the name of the node that sent it, and whether they are static.
OnTransforms = Callable[[Sequence[StampedTransform], str, bool], None]


class TfListener:
    """Stores the messages of a graph's tf in `buffer`; each batch of messages sets `arrived`.

    A jump of ROS time into the past, such as a bag that starts again, clears the buffer.
    """

    def __init__(self, graph: TypedGraph, on_refusal: Callable[[str], None]) -> None:
        self.buffer = TransformBuffer()
        self.arrived = asyncio.Event()
        self.on_transforms: OnTransforms | None = None
        self._graph = graph
        self._codec = graph.store.codec(TF_TYPE)
        self._on_refusal = on_refusal
        self._last_now_ns = 0

    def handler(self, is_static: bool, header: Mapping[str, str]) -> OnMessages:
        """Return the handler for one publisher's messages; it reports messages that do not fit the type."""
        authority = header.get("callerid", UNKNOWN_AUTHORITY)

        def handle_payloads(payloads: Sequence[bytes]) -> None:
            self._notice_jump(self._graph.now().to_ns())
            for payload in payloads:
                try:
                    message = self._codec.decode(payload)
                except RostetherError as error:
                    self._on_refusal(str(error))
                    continue
                self._add_transforms(message, authority, is_static)
            self.arrived.set()

        return handle_payloads

    def _add_transforms(self, message: Any, authority: str, is_static: bool) -> None:
        accepted = []
        for stamped in from_message(message):
            refusal = self.buffer.set_transform(stamped, authority=authority, is_static=is_static)
            if refusal:
                self._on_refusal(refusal)
            else:
                accepted.append(stamped)
        if accepted and self.on_transforms is not None:
            self.on_transforms(accepted, authority, is_static)

    def _notice_jump(self, now_ns: int) -> None:
        if now_ns < self._last_now_ns:
            self._on_refusal("Detected jump back in time. Clearing TF buffer.")
            self.buffer.clear()
        self._last_now_ns = now_ns


@asynccontextmanager
async def tf_listener(
    graph: TypedGraph, on_refusal: Callable[[str], None] = lambda _: None
) -> AsyncIterator[TfListener]:
    """Listen to tf during the block; `on_refusal` gets a line about each refused message or transform."""
    listener = TfListener(graph, on_refusal)
    message_type = graph.store.registry.message_type(TF_TYPE)
    async with AsyncExitStack() as stack:
        for topic, is_static in ((TF_STATIC_TOPIC, True), (TF_TOPIC, False)):
            handler_for = partial(listener.handler, is_static)
            subscriber = await graph.raw.subscribe(
                topic, message_type, handler_for({}), on_connection=handler_for
            )
            stack.push_async_callback(subscriber.close)
        yield listener
