"""The Protocol of a session for its endpoints: how they receive from the board and send to it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Protocol, TypeAlias

from rostether.bridge.outbound.outbox import Outbox

Receive: TypeAlias = Callable[[list[bytes]], None]


class BoardLine(Protocol):
    """One connection to a board, while it lasts."""

    @property
    def receivers(self) -> dict[int, Receive]:
        """The receiver of each topic id's messages; endpoints add and remove themselves."""

    @property
    def outbox(self) -> Outbox:
        """The queue of messages to the board."""

    def pause_until(self, wait: Callable[[], Awaitable[object]]) -> bool:
        """Read nothing from the board until `wait()` ends; return False if the line cannot pause."""

    def rescan(self, payload: bytes) -> None:
        """Handle the frames inside a payload that does not have its type's layout.

        Noise before these frames looked like the header of a message.
        """

    def call_started(self) -> None:
        """Record that the board waits for a response."""

    def call_finished(self) -> None:
        """Record that the response was sent or canceled."""


def stop_receiving(line: BoardLine, topic_id: int, receive: Receive) -> None:
    """Remove a receiver, unless another endpoint has its topic id now."""
    if line.receivers.get(topic_id) == receive:
        del line.receivers[topic_id]
