"""The connection to a device that carries its bytes, and the callbacks. Transports know nothing about ROS.

Data arrives by callback, not by `await read()`: a flood then costs one call per chunk, and no task switch.
"""

from __future__ import annotations

from typing import Protocol

from rostether.errors import TransportError
from rostether.transports.board_keys import NO_PROOF, Proof

# Limits of written bytes that wait, for transports with their own buffers: those of asyncio's sockets.
HIGH_WATER_BYTES = 64 * 1024
LOW_WATER_BYTES = 16 * 1024


class Receiver(Protocol):
    """Implemented by the users of a transport."""

    def data_received(self, data: bytes) -> None:
        """Handle a chunk of the stream, which may end anywhere."""

    def connection_lost(self, error: TransportError | None) -> None:
        """Handle the end of the transport, once; None after `close`."""

    def pause_writing(self) -> None:
        """Stop writing: the write buffer is above its high-water mark."""

    def resume_writing(self) -> None:
        """Write again: the write buffer is below its low-water mark."""


class SmallWriter:
    """Base class of a `Receiver` that writes so little at a time that it need not wait for room."""

    def pause_writing(self) -> None:
        """Do nothing."""

    def resume_writing(self) -> None:
        """Do nothing."""


class Transport(Protocol):
    """An open connection to one device, which carries bytes."""

    @property
    def peer(self) -> str:
        """The other side's name for users: `/dev/ttyACM0`, `tcp 192.168.1.7:51234`."""

    @property
    def remote(self) -> str | None:
        """The network address of the other side, without a port; None without a network."""

    @property
    def proof(self) -> Proof:
        """The board's key and certificate with which the other side has authenticated."""

    @property
    def can_pause(self) -> bool:
        """Whether pause_reading only slows the sender down (TCP, pty); else bytes are lost (serial, UDP)."""

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that are still waiting."""

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once. Bytes received earlier are kept."""

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended."""

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""

    def close(self) -> None:
        """Flush queued data for at most a second, then close. Idempotent."""

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""


class PausingTransport:
    """Base class of transports that pause and resume the writing of their receiver."""

    remote: str | None = None
    proof: Proof = NO_PROOF

    def __init__(self) -> None:
        self._receiver: Receiver | None = None
        self._is_writing_paused = False

    def pause_writing(self) -> None:
        """Report that the write buffer is full."""
        self._is_writing_paused = True
        if self._receiver is not None:
            self._receiver.pause_writing()

    def resume_writing(self) -> None:
        """Report that the write buffer has drained."""
        self._is_writing_paused = False
        if self._receiver is not None:
            self._receiver.resume_writing()


class Listener(Protocol):
    """A server that creates a transport for each peer."""

    @property
    def address(self) -> str:
        """The listening address, with the port that was bound."""

    async def close(self) -> None:
        """Stop listening and end all its transports. Idempotent."""
