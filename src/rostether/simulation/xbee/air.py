"""The air between simulated radios: the receivers of a packet, its delay, and lost packets.

802.15.4 at 2.4 GHz: 250 kbit/s for all radios of a channel together. A radio waits for a free channel, sends,
and expects an acknowledgement; without one it sends again, at most 3 times (more with RR). The packet or its
acknowledgement may be lost. In Digi's MAC modes (MM=0 and 3), a radio drops a packet that it already has; in
others it delivers the packet twice.
"""

from __future__ import annotations

import asyncio
import random
from collections.abc import Callable

from msgspec import Struct

from rostether.simulation.xbee.radio import BROADCAST, SimulatedRadio, Transmission

_BYTE_S = 8 / 250_000
# Preamble, length, MAC header with addresses, checksum.
_HEADER_BYTES = 6 + 11 + 2
_ACKNOWLEDGEMENT_S = 11 * _BYTE_S + 0.0002
_BACKOFF_SLOT_S = 0.00032
_BACKOFF_SLOTS = 7
_MAC_RETRIES = 3

_NO_ACKNOWLEDGEMENT = 0x01
_NO_NETWORK_ACKNOWLEDGEMENT = 0x21
_DELIVERED = 0x00


class AirConditions(Struct, frozen=True):
    """The conditions of transmissions.

    `loss` is the probability that a transmission or an acknowledgement is lost. `repeat` is the probability
    that a packet arrives twice. `delay_s` delays each packet; `rssi_dbm` is its signal strength.
    """

    loss: float = 0.0
    repeat: float = 0.0
    delay_s: float = 0.0
    rssi_dbm: int = -60


class AirCounts(Struct):
    """Counts since the start; `lost_packets` arrived in none of their transmissions."""

    packets: int = 0
    transmissions: int = 0
    lost_packets: int = 0
    repeated_packets: int = 0


class Air:
    """Carries packets between radios; `on_change(radio)` is called when a radio has bytes for its host."""

    def __init__(
        self, conditions: AirConditions, on_change: Callable[[SimulatedRadio], None], *, seed: int = 0
    ) -> None:
        self.conditions = conditions
        self.counts = AirCounts()
        self._on_change = on_change
        # The same seed gives the same losses; nothing here is secret.
        self._random = random.Random(seed)  # noqa: S311
        self._loop = asyncio.get_running_loop()
        self._radios: list[SimulatedRadio] = []
        self._busy: set[int] = set()
        self._free_at_s = 0.0

    def add(self, radio: SimulatedRadio) -> None:
        """Add a radio."""
        self._radios.append(radio)

    def send_from(self, radio: SimulatedRadio) -> None:
        """Send the next packet of a radio, unless it is sending one already."""
        if radio.outgoing and radio.serial_number not in self._busy:
            self._busy.add(radio.serial_number)
            self.counts.packets += 1
            self._attempt(radio, radio.outgoing[0], attempt=0, was_received=False)

    def _attempt(
        self, radio: SimulatedRadio, packet: Transmission, *, attempt: int, was_received: bool
    ) -> None:
        self.counts.transmissions += 1
        slots = self._random.randint(0, _BACKOFF_SLOTS)
        start_s = max(self._loop.time(), self._free_at_s) + slots * _BACKOFF_SLOT_S
        end_s = start_s + (_HEADER_BYTES + len(packet.payload)) * _BYTE_S
        self._free_at_s = end_s + _ACKNOWLEDGEMENT_S
        self._loop.call_at(end_s, self._arrive, radio, packet, attempt, was_received)

    def _arrive(self, radio: SimulatedRadio, packet: Transmission, attempt: int, was_received: bool) -> None:
        receivers = [each for each in self._radios if each is not radio and _is_receiver(each, radio, packet)]
        arrives = bool(receivers) and not self._is_lost()
        if arrives:
            for receiver in receivers:
                drops_repeats = receiver.model.is_mesh or receiver.registers["MM"] in (0, 3)
                if not (was_received and drops_repeats):
                    self._deliver(receiver, radio, packet)
        needs_acknowledgement = _is_acknowledged(radio, packet)
        is_acknowledged = arrives and not self._is_lost()
        if needs_acknowledgement and not is_acknowledged:
            if attempt < _max_retries(radio):
                self._attempt(radio, packet, attempt=attempt + 1, was_received=was_received or arrives)
                return
            status = _NO_NETWORK_ACKNOWLEDGEMENT if radio.model.is_mesh else _NO_ACKNOWLEDGEMENT
        else:
            status = _DELIVERED
        self.counts.lost_packets += not (arrives or was_received)
        self._busy.discard(radio.serial_number)
        radio.outgoing.popleft()
        radio.transmitted(packet, status, attempt)
        self._on_change(radio)
        self.send_from(radio)

    def _deliver(self, receiver: SimulatedRadio, sender: SimulatedRadio, packet: Transmission) -> None:
        is_repeated = self._random.random() < self.conditions.repeat
        self.counts.repeated_packets += is_repeated
        for _ in range(1 + is_repeated):
            self._loop.call_later(self.conditions.delay_s, self._receive, receiver, sender, packet)

    def _receive(self, receiver: SimulatedRadio, sender: SimulatedRadio, packet: Transmission) -> None:
        source = sender.short_address, sender.serial_number
        if packet.remote is not None:
            receiver.remote_received(*source, packet.remote)
        else:
            receiver.radio_received(*source, packet.payload, self.conditions.rssi_dbm)
        self._on_change(receiver)

    def _is_lost(self) -> bool:
        return self._random.random() < self.conditions.loss


def _is_receiver(receiver: SimulatedRadio, sender: SimulatedRadio, packet: Transmission) -> bool:
    """Return whether two radios are in one network, and the packet is for the receiver."""
    if receiver.model.is_mesh != sender.model.is_mesh:
        return False
    if any(receiver.registers[name] != sender.registers[name] for name in ("CH", "ID")):
        return False
    if packet.is_long:
        return packet.destination == receiver.serial_number
    return packet.destination in (BROADCAST, receiver.short_address)


def _is_acknowledged(sender: SimulatedRadio, packet: Transmission) -> bool:
    is_broadcast = packet.destination == BROADCAST and not packet.is_long
    return not is_broadcast and (sender.model.is_mesh or sender.registers["MM"] in (0, 2))


def _max_retries(sender: SimulatedRadio) -> int:
    if sender.model.is_mesh:
        return sender.registers["RR"]
    return (1 + sender.registers["RR"]) * (1 + _MAC_RETRIES) - 1
