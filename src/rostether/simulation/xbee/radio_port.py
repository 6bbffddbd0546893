"""The serial port of a simulated radio: moves bytes at the port's speed, and runs the radio's timer."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import TransportError
from rostether.simulation.xbee.radio import SimulatedRadio
from rostether.transports.transport import SmallWriter, Transport

_BITS_PER_BYTE = 10
# A faster host must wait, as with a real port; a longer backlog would delay all bytes.
_BACKLOG_S = 0.05
# The radio sends while bytes still arrive, so they arrive in small pieces: 6 ms of 57600 baud.
_PIECE_BYTES = 32


class RadioPort(SmallWriter):
    """Connects a radio and the transport of its serial port.

    `on_packets(radio)` is called when the radio may have packets to send.
    With `host_baud`, bytes arrive only while the radio has the same speed.
    """

    def __init__(
        self,
        radio: SimulatedRadio,
        transport: Transport,
        on_packets: Callable[[SimulatedRadio], None],
        *,
        host_baud: int | None = None,
    ) -> None:
        self.radio = radio
        self._transport = transport
        self._on_packets = on_packets
        self._host_baud = host_baud
        self._loop = asyncio.get_running_loop()
        self._in_free_s = 0.0
        self._out_free_s = 0.0
        self._timer: asyncio.TimerHandle | None = None
        self._is_closed = False
        transport.start(self)

    def data_received(self, data: bytes) -> None:
        """Pass bytes to the radio after the time that the line needs for them."""
        now_s = self._loop.time()
        self._in_free_s = max(self._in_free_s, now_s)
        for start in range(0, len(data), _PIECE_BYTES):
            piece = data[start : start + _PIECE_BYTES]
            self._in_free_s += self._line_s(piece)
            self._loop.call_at(self._in_free_s, self._to_radio, piece)
        if self._in_free_s - now_s > _BACKLOG_S:
            self._transport.pause_reading()
            self._loop.call_at(self._in_free_s, self._transport.resume_reading)

    def connection_lost(self, error: TransportError | None) -> None:
        """Stop passing bytes."""
        self._is_closed = True

    def update(self, baud: int | None = None) -> None:
        """Send the radio's data for its host and for other radios, and set its timer.

        `baud` is the speed before a change: the answer to ATCN is still sent at the previous speed.
        """
        if data := self.radio.serial_to_send():
            self._out_free_s = max(self._out_free_s, self._loop.time()) + self._line_s(data)
            if self._has_host_baud(baud):
                self._loop.call_at(self._out_free_s, self._to_host, data)
        self._on_packets(self.radio)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        due_s = self.radio.get_timer()
        if due_s is not None and not self._is_closed:
            self._timer = self._loop.call_at(due_s, self._handle_timer)

    def close(self) -> None:
        """Close the port. Idempotent."""
        self._is_closed = True
        if self._timer is not None:
            self._timer.cancel()
        self._transport.close()

    def _to_radio(self, data: bytes) -> None:
        if not self._is_closed and self._has_host_baud():
            baud = self.radio.baud
            self.radio.serial_received(data, self._loop.time())
            self.update(baud)

    def _to_host(self, data: bytes) -> None:
        if not self._is_closed:
            self._transport.write(data)

    def _handle_timer(self) -> None:
        self._timer = None
        self.radio.handle_timer(self._loop.time())
        self.update()

    def _has_host_baud(self, baud: int | None = None) -> bool:
        return self._host_baud is None or self._host_baud == (baud or self.radio.baud)

    def _line_s(self, data: bytes) -> float:
        return len(data) * _BITS_PER_BYTE / self.radio.baud
