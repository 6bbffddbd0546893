"""The session as its endpoints see it: how they receive from the board and send to it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Protocol

from rostether.bridge.outbound.outbox import Outbox


class BoardLine(Protocol):
    """One connection to a board, while it lasts."""

    @property
    def receivers(self) -> dict[int, Callable[[list[bytes]], None]]:
        """Who takes the messages of a topic id; endpoints put themselves in and take themselves out."""

    @property
    def outbox(self) -> Outbox:
        """What goes to the board."""

    def congested(self, wait: Callable[[], Awaitable[object]]) -> bool:
        """Read nothing from the board until `wait()` ends; False, and nothing awaited, if it cannot pause."""

    def rescan(self, payload: bytes) -> None:
        """Handle what noise has swallowed: the frames in a message that does not have its type's layout."""

    def call_started(self) -> None:
        """Note that the board itself waits for a response."""

    def call_finished(self) -> None:
        """Note that the response was sent or given up."""
