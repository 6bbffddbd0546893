"""The robots that answer a sender: last status, loss, and need for unicast. Without sockets or clocks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

from msgspec import Struct

from rostether.errors import RemoteProtocolError
from rostether.platform.status_frame import RobotStatus, decode_status

# A robot with a higher loss also gets its commands by unicast.
MAX_LOSS = 0.1

# Fewer frames are not enough to compute the loss.
_MIN_FRAMES = 10

# A robot that does not answer within this time gets no more unicast.
_FORGET_S = 10.0

# A base station commands about ten robots; the limit keeps forged ids from filling the memory.
_MAX_ROBOTS = 1000

_U32 = 1 << 32

SocketAddress: TypeAlias = tuple[str, int] | tuple[str, int, int, int]


class RobotKey(NamedTuple):
    """Identifies a robot, even if two have the same id: the id, and the host that answers."""

    robot_id: int
    host: str


class Robot(Struct):
    """One robot: its last status with its time, and its address. `loss` is a fraction, 0 to 1."""

    status: RobotStatus
    address: SocketAddress
    answered_s: float
    loss: float | None = None
    needs_unicast: bool = False
    # The counts in the status of the last measurement of `loss`.
    received_count: int = 0
    lost_count: int = 0

    @property
    def key(self) -> RobotKey:
        """The robot's id and host."""
        return RobotKey(self.status.robot_id, self.address[0])

    def measure(self, status: RobotStatus) -> None:
        """Compare a status with the last measurement."""
        received = (status.received_count - self.received_count) % _U32
        lost = (status.lost_count - self.lost_count) % _U32
        if received + lost < _MIN_FRAMES:
            return
        self.loss = lost / (received + lost)
        self.received_count, self.lost_count = status.received_count, status.lost_count
        # Unicast stays on: with it, the measured loss is no longer that of multicast.
        self.needs_unicast = self.needs_unicast or self.loss > MAX_LOSS


class RobotTable:
    """Robots by id and host. Two hosts with the same id are two entries."""

    def __init__(self, key: bytes) -> None:
        self._key = key
        self.robots: dict[RobotKey, Robot] = {}

    def receive(
        self, datagram: bytes, address: SocketAddress, epoch_us: int, now_s: float
    ) -> RobotStatus | None:
        """Return the status in a datagram; None if it is damaged, forged, old, or answers another sender."""
        try:
            status = decode_status(datagram, self._key)
        except RemoteProtocolError:
            return None
        if status.epoch_us != epoch_us:
            return None
        key = RobotKey(status.robot_id, address[0])
        robot = self.robots.get(key)
        if robot is None:
            if len(self.robots) >= _MAX_ROBOTS:
                return None
            robot = self.robots[key] = Robot(status, address, now_s)
        elif robot.status.epoch_us == epoch_us and status.sequence <= robot.status.sequence:
            return None
        elif robot.status.epoch_us != epoch_us:
            robot.received_count = robot.lost_count = 0
        robot.status, robot.address, robot.answered_s = status, address, now_s
        robot.measure(status)
        return status

    def unicast_addresses(self, now_s: float) -> list[SocketAddress]:
        """Return the unicast addresses that get frames besides the group."""
        return [
            robot.address
            for robot in self.robots.values()
            if robot.needs_unicast and now_s - robot.answered_s < _FORGET_S
        ]


def hosts_of_duplicate_ids(keys: Iterable[RobotKey]) -> dict[int, list[str]]:
    """Return the ids that several hosts share, with the hosts."""
    hosts: dict[int, list[str]] = {}
    for robot_id, host in sorted(keys):
        hosts.setdefault(robot_id, []).append(host)
    return {robot_id: found for robot_id, found in hosts.items() if len(found) > 1}
