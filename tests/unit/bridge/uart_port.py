"""A serial port whose board may have another baud rate: each side reads the other's bytes at its own rate."""

from __future__ import annotations

from rostether.errors import TransportError
from rostether.transports.board_keys import NO_PROOF
from rostether.transports.transport import Receiver, Transport
from unit.rosserial.uart_line import garbled


class UartPort:
    """`wire` leads to the board, whose UART has `board_baud`."""

    can_pause = False
    has_baud = True
    write_buffer_bytes = 0

    remote: str | None = None
    proof = NO_PROOF

    def __init__(self, wire: Transport, baud: int, board_baud: int, peer: str = "/dev/ttyACM0") -> None:
        self.peer = peer
        self._wire = wire
        self._baud = baud
        self._board_baud = board_baud
        self._receiver: Receiver | None = None
        self._unread = b""
        self._is_started = False
        self.pause_reading = wire.pause_reading
        self.resume_reading = wire.resume_reading
        self.close = wire.close
        self.wait_closed = wire.wait_closed

    def set_baud(self, baud: int) -> bool:
        self._baud = baud
        return True

    def set_board_baud(self, baud: int) -> None:
        """Give the board a sketch with another rate."""
        self._board_baud = baud

    def release(self, unread: bytes = b"") -> None:
        self._receiver, self._unread = None, unread

    def start(self, receiver: Receiver) -> None:
        self._receiver = receiver
        if not self._is_started:
            self._is_started = True
            self._wire.start(self)
        unread, self._unread = self._unread, b""
        if unread:
            receiver.data_received(unread)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self._wire.write(garbled(bytes(data), self._baud, self._board_baud))

    def data_received(self, data: bytes) -> None:
        if self._receiver is not None:
            self._receiver.data_received(garbled(data, self._board_baud, self._baud))

    def connection_lost(self, error: TransportError | None) -> None:
        if self._receiver is not None:
            self._receiver.connection_lost(error)

    def pause_writing(self) -> None:
        pass

    def resume_writing(self) -> None:
        pass
