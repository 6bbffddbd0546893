"""The Protocol of a link for the outbox: how it encodes messages, and which the board has room for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from rostether.rosserial.unread_bytes import UnreadBytes


class FrameSource(Protocol):
    """The sending functions of a link."""

    unread: UnreadBytes

    def data_to_send(self) -> bytes:
        """Return the control traffic that is due."""

    def encode_message(self, topic_id: int, payload: bytes) -> bytes:
        """Return one frame. Raises LocalProtocolError for an id that the board did not announce."""

    def encode_messages(self, topic_id: int, payloads: Sequence[bytes]) -> bytes:
        """Return the frames. Raises LocalProtocolError for an id that the board did not announce."""
