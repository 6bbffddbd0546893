"""Handles to the publications of one node: several may share a publication, which ends with the last one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Generic, Protocol, TypeVar

from rostether.errors import TypeMismatchError
from rostether.msgdef.interface import MessageType, agree


class Publication(Protocol):
    """One topic that a node publishes, shared by its handles."""

    topic: str
    type: MessageType
    handle_count: int

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""

    @property
    def dropped_count(self) -> int:
        """How many messages slow subscribers have lost so far, in total."""

    def publish(self, payloads: Sequence[bytes]) -> bool:
        """Send or queue a batch; False means: await `drained` first."""

    async def drained(self, timeout_s: float) -> None:
        """Wait until all backlogs are low, at most `timeout_s`."""


PublicationT = TypeVar("PublicationT", bound=Publication)


class PublisherHandle(Generic[PublicationT]):
    """A `graph.ports.Publisher`: a handle to a publication; closing the last handle calls `on_last_close`."""

    def __init__(
        self, publication: PublicationT, on_last_close: Callable[[PublicationT], Awaitable[None]]
    ) -> None:
        self.publication = publication
        self._on_last_close = on_last_close
        self._is_closed = False
        publication.handle_count += 1

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self.publication.topic

    @property
    def type(self) -> MessageType:
        """The advertised type."""
        return self.publication.type

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return self.publication.subscriber_count

    @property
    def dropped_count(self) -> int:
        """How many messages slow subscribers have lost so far, in total."""
        return self.publication.dropped_count

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        """Queue the payloads for every subscriber; False means: await `drained` first."""
        return self._is_closed or self.publication.publish(payloads)

    async def drained(self, timeout_s: float) -> None:
        """Wait until all backlogs are low, at most `timeout_s`. Each call counts as one pause."""
        await self.publication.drained(timeout_s)

    async def close(self) -> None:
        """Close the handle; the last one unadvertises the topic. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            self.publication.handle_count -= 1
            if self.publication.handle_count == 0:
                await self._on_last_close(self.publication)


def check_same_type(topic: str, published: MessageType, wanted: MessageType) -> None:
    """Check that a handle has the type of its node's publication. Raises TypeMismatchError."""
    if not agree(published.md5sum, wanted.md5sum):
        raise TypeMismatchError(
            f"this node publishes {topic} as {published.name}, not as {wanted.name}; choose another topic"
        )
