"""A simulated XBee network: the radio of a host, and the radios of boards, each set up for one PAN.

host ── serial port ── radio ── air ── radio ── serial port ── board
                                  └─── radio ── serial port ── board
"""

from __future__ import annotations

from rostether.simulation.xbee.air import Air, AirConditions
from rostether.simulation.xbee.radio import SimulatedRadio
from rostether.simulation.xbee.radio_port import RadioPort
from rostether.simulation.xbee.registers import BAUD_RATES, SERIES_1, Model
from rostether.transports.transport import Transport

# Serial numbers from here on belong to the manufacturer, Digi.
_FIRST_SERIAL_NUMBER = 0x0013A20040A10000
_BAUD = 57600
_PAN_ID = 0x1331
_CHANNEL = 0x0D
_API_MODE = 2
_NO_SHORT_ADDRESS = 0xFFFF


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
