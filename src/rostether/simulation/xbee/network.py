"""A simulated XBee network: the radio of a host, and the radios of boards, each set up for one PAN.

host ── serial port ── radio ── air ── radio ── serial port ── board
                                  └─── radio ── serial port ── board

The ports move bytes at their speed, and run the radios' timers.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import TransportError
from rostether.simulation.xbee.air import Air, AirConditions
from rostether.simulation.xbee.radio import SimulatedRadio
from rostether.simulation.xbee.registers import BAUD_RATES, SERIES_1, Model
from rostether.transports.transport import SmallWriter, Transport

# Serial numbers from here on belong to the manufacturer, Digi.
_FIRST_SERIAL_NUMBER = 0x0013A20040A10000
_BAUD = 57600
_PAN_ID = 0x1331
_CHANNEL = 0x0D
_API_MODE = 2
_NO_SHORT_ADDRESS = 0xFFFF

_BITS_PER_BYTE = 10
# A faster host must wait, as with a real port; a longer backlog would delay all bytes.
_BACKLOG_S = 0.05
# The radio sends while bytes still arrive, so they arrive in small pieces: 6 ms of 57600 baud.
_PIECE_BYTES = 32


class XbeeNetwork:
    """The radios of one network, and new radios that are not set up yet."""

    def __init__(self, conditions: AirConditions, *, model: Model = SERIES_1, seed: int = 0) -> None:
        self.model = model
        self.air = Air(conditions, self._update, seed=seed)
        self._ports: dict[int, RadioPort] = {}
        self._radio_count = 0

    def add_fresh(self, transport: Transport) -> SimulatedRadio:
        """Add a radio with its factory settings; `transport` is its serial port."""
        radio = self._new_radio()
        self.connect(radio, transport)
        return radio

    def add_coordinator(self, transport: Transport) -> SimulatedRadio:
        """Add the radio of the host, in API mode 2, with the 16-bit address 0."""
        radio = self._new_radio()
        self._set_up(radio, AP=_API_MODE, **({} if self.model.is_mesh else {"CE": 1, "MY": 0}))
        self.connect(radio, transport)
        return radio

    def add_board(
        self, transport: Transport, coordinator: SimulatedRadio, *, short_address: int | None = None
    ) -> SimulatedRadio:
        """Add the radio of a board, which sends to the coordinator; by default from its 64-bit address."""
        radio = self._new_radio()
        if self.model.is_mesh or short_address is None:
            own = {} if self.model.is_mesh else {"MY": _NO_SHORT_ADDRESS}
            high, low = divmod(coordinator.serial_number, 2**32)
            self._set_up(radio, DH=high, DL=low, RO=5, **own)
        else:
            self._set_up(radio, DL=0, RO=5, MY=short_address)
        self.connect(radio, transport)
        return radio

    def connect(
        self, radio: SimulatedRadio, transport: Transport, *, host_baud: int | None = None
    ) -> RadioPort:
        """Connect a radio's serial port; this replaces its previous connection."""
        if (before := self._ports.get(radio.serial_number)) is not None:
            before.close()
        port = RadioPort(radio, transport, self.air.send_from, host_baud=host_baud)
        self._ports[radio.serial_number] = port
        return port

    def close(self) -> None:
        """Close the serial ports of all radios."""
        for port in self._ports.values():
            port.close()

    def _new_radio(self) -> SimulatedRadio:
        radio = SimulatedRadio(self.model, _FIRST_SERIAL_NUMBER + self._radio_count)
        self._radio_count += 1
        self.air.add(radio)
        return radio

    def _set_up(self, radio: SimulatedRadio, **values: int) -> None:
        common = {"ID": _PAN_ID, "CH": _CHANNEL, "BD": BAUD_RATES.index(_BAUD)}
        for name, value in (common | values).items():
            radio.registers.execute(name, value)
        radio.registers.execute("WR", None)
        radio.registers.apply()

    def _update(self, radio: SimulatedRadio) -> None:
        if (port := self._ports.get(radio.serial_number)) is not None:
            port.update()


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
