"""Asks the robots at one address for their status, and measures loss and clocks. It sends no commands."""

from __future__ import annotations

import asyncio
import time

from msgspec import Struct

from rostether.graph.ports import Report
from rostether.platform.command_link import REPEAT_S, CommandSender, SenderSettings
from rostether.platform.datagram_sender import DatagramSender
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.robot_table import Robot, RobotKey, RobotTable, SocketAddress


class ClockOffset(Struct, frozen=True):
    """How far a robot's clock is ahead of this machine's; `error_s` is half of the round trip."""

    offset_s: float
    error_s: float


class Survey:
    """Queries to one group or machine, and the robots that answered them.

    Unlike `FleetSender`, it never adds unicast, so that the loss is that of `address`. Raises ConfigError for
    an invalid address.
    """

    def __init__(
        self,
        settings: SenderSettings,
        address: GroupAddress,
        report: Report,
        commands: CommandSender | None = None,
    ) -> None:
        self._commands = commands or CommandSender(settings, time.time_ns() // 1000)
        self._sender = DatagramSender(address.checked(), report, on_datagram=self._receive)
        self._table = RobotTable(settings.key)
        # When each query was sent, by its sequence number.
        self._sent_us: dict[int, int] = {}
        self._answered = asyncio.Event()
        self.clocks: dict[RobotKey, ClockOffset] = {}

    @property
    def robots(self) -> dict[RobotKey, Robot]:
        """The robots that have answered."""
        return self._table.robots

    async def run(self, duration_s: float, *, until_answered: bool = False) -> None:
        """Send queries for this time, then close the sockets.

        With `until_answered`, stop at the first answer.
        """
        end_s = time.monotonic() + duration_s
        try:
            while time.monotonic() < end_s and not (until_answered and self._answered.is_set()):
                query = self._commands.query()
                self._sent_us[self._commands.sequence] = time.time_ns() // 1000
                self._sender.send(query)
                await asyncio.sleep(REPEAT_S)
        finally:
            self._sender.close()

    def _receive(self, datagram: bytes, address: SocketAddress) -> None:
        received_us = time.time_ns() // 1000
        status = self._table.receive(datagram, address, self._commands.epoch_us, time.monotonic())
        if status is None:
            return
        self._answered.set()
        sent_us = self._sent_us.get(status.sequence)
        if status.host is not None and sent_us is not None:
            offset_us = status.host.clock_us - (sent_us + received_us) / 2
            clock = ClockOffset(offset_us / 1e6, (received_us - sent_us) / 2e6)
            key = RobotKey(status.robot_id, address[0])
            known = self.clocks.get(key)
            # The shortest round trip gives the best value.
            if known is None or clock.error_s < known.error_s:
                self.clocks[key] = clock
