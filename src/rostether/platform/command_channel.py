"""The sockets of a sender: they send frames by multicast and unicast, and receive statuses."""

from __future__ import annotations

import time

from rostether.errors import ConfigError
from rostether.graph.ports import Level, Report
from rostether.platform.command_link import CommandSender, SenderSettings
from rostether.platform.datagram_sender import DatagramSender
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.robot_table import RobotTable, SocketAddress, hosts_of_duplicate_ids
from rostether.platform.status_frame import Refusal, RobotStatus

# Unicast to a large fleet overloads the Wi-Fi channel: 20 robots need about 400 datagrams a second.
MAX_UNICAST = 100
# Epochs after this one are ignored: they would leave no epochs for later senders.
_LAST_EPOCH_US = 1 << 62


class CommandChannel:
    """Sends one sender's frames; `report` gets a line when sending fails, or two robots have the same id.

    With `reports_refusals`, it also gets a line when a robot refuses the sender. Raises ConfigError for an
    address that is not numeric.
    """

    def __init__(
        self,
        address: GroupAddress,
        report: Report,
        *,
        key: bytes,
        unicast: tuple[str, ...] = (),
        reports_refusals: bool = True,
    ) -> None:
        if len(unicast) > MAX_UNICAST:
            raise ConfigError(f"at most {MAX_UNICAST} unicast addresses are allowed, not {len(unicast)}")
        self._sender = DatagramSender(address.checked(), report, on_datagram=self._receive)
        self._unicast = [(GroupAddress(host, address.port).checked().group, address.port) for host in unicast]
        self._report = report
        self._reports_refusals = reports_refusals
        # The robots that refuse this sender, with the reasons.
        self.refused: dict[int, Refusal] = {}
        self._duplicates: set[int] = set()
        self.table = RobotTable(key)
        # Statuses must answer this epoch.
        self.epoch_us = 0
        self._last_epoch_us = 0

    def send(self, datagram: bytes) -> None:
        """Send to the group, and to the robots that need unicast."""
        # Unicast first: it arrives even while multicast is delayed by a sleeping station.
        for address in (*self._unicast, *self.table.unicast_addresses(time.monotonic())[:MAX_UNICAST]):
            self._sender.send_to(datagram, address)
        self._sender.send(datagram)

    @property
    def is_overtaken(self) -> bool:
        """Whether a robot has obeyed a sender with a later epoch, so that it refuses this one."""
        return self._last_epoch_us > self.epoch_us

    def start_sender(self, settings: SenderSettings) -> CommandSender:
        """Return a sender whose epoch is the current time, or later if a known sender has a later epoch.

        If the clock of an earlier sender was ahead, robots would otherwise refuse this sender and its stops.
        """
        self.epoch_us = max(time.time_ns() // 1000, self._last_epoch_us + 1)
        self.refused.clear()
        return CommandSender(settings, self.epoch_us)

    def close(self) -> None:
        """Close the sockets. Idempotent."""
        self._sender.close()

    def _receive(self, datagram: bytes, address: SocketAddress) -> None:
        robot_count = len(self.table.robots)
        status = self.table.receive(datagram, address, self.epoch_us, time.monotonic())
        if status is None:
            return
        if status.last_epoch_us <= _LAST_EPOCH_US:
            self._last_epoch_us = max(self._last_epoch_us, status.last_epoch_us)
        if status.refusal is Refusal.NONE:
            self.refused.pop(status.robot_id, None)
        elif self.refused.get(status.robot_id) is not status.refusal:
            self.refused[status.robot_id] = status.refusal
            if self._reports_refusals:
                self._report(Level.WARN, refusal_text(status))
        if len(self.table.robots) == robot_count:
            return
        for robot_id, hosts in hosts_of_duplicate_ids(self.table.robots).items():
            if robot_id not in self._duplicates:
                self._duplicates.add(robot_id)
                self._report(Level.WARN, duplicate_text(robot_id, hosts))


def refusal_text(status: RobotStatus) -> str:
    """Return why a robot does not obey, and what to do."""
    robot = f"robot {status.robot_id}"
    by = f"{status.holder} commands it" if status.holder else "another sender commanded it"
    if status.refusal is Refusal.HELD:
        return f"{robot} does not obey: {by}; stop that sender, or: rostether fleet stop {status.robot_id}"
    if status.refusal is Refusal.OLDER:
        return f"{robot} does not obey: {by} after this sender started; restart this sender"
    return f"{robot} does not obey: it expects commands of another type; send the ~type of its receiver"


def duplicate_text(robot_id: int, hosts: list[str]) -> str:
    """Return a warning about robots with the same id, and what to do."""
    return f"{len(hosts)} robots have the id {robot_id}: {', '.join(hosts)}; give one of them another ~robot"
