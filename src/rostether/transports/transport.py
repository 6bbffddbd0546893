"""The byte pipe a device is reached through, and what it calls back. Transports know no ROS.

Reading is by callback, not by `await read()`: a flood then costs one call a chunk and no task switch.
"""

from __future__ import annotations

from typing import Protocol

from rostether.errors import TransportError
from rostether.transports.board_keys import Proof


class Receiver(Protocol):
    """Implemented by the users of a transport."""

    def data_received(self, data: bytes) -> None:
        """Handle a chunk, in order, cut anywhere."""

    def connection_lost(self, error: TransportError | None) -> None:
        """Learn once that the pipe ended; None after our own close()."""

    def pause_writing(self) -> None:
        """Learn that the write buffer is above its high-water mark."""

    def resume_writing(self) -> None:
        """Learn that the write buffer has drained below its low-water mark."""


class Transport(Protocol):
    """An open byte pipe to one device."""

    @property
    def peer(self) -> str:
        """The other side's name for users: `/dev/ttyACM0`, `tcp 192.168.1.7:51234`."""

    @property
    def remote(self) -> str | None:
        """The network address of the other side, without a port; None where it is on no network."""

    @property
    def proof(self) -> Proof:
        """The key and the certificate of a single board that the other side has proven to have."""

    @property
    def can_pause(self) -> bool:
        """Whether pause_reading slows the sender down (TCP, pty) or makes it lose bytes (serial, UDP)."""

    @property
    def write_buffer_bytes(self) -> int:
        """How many written bytes have not left yet."""

    def start(self, receiver: Receiver) -> None:
        """Begin to deliver; called once. Nothing received before it is lost."""

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; after the pipe ended it does nothing."""

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""

    def close(self) -> None:
        """Flush queued data for at most a second, then close. Idempotent."""

    async def wait_closed(self) -> None:
        """Wait until the pipe has ended."""


class Listener(Protocol):
    """A server that makes a transport of each peer that comes."""

    @property
    def address(self) -> str:
        """Where it listens, with the port that was really bound."""

    async def close(self) -> None:
        """Stop listening and end all its transports. Idempotent."""
