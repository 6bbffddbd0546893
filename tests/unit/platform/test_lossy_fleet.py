"""Twenty robots on bad Wi-Fi, in simulated time: a third of the datagrams is lost, the others are late."""

from __future__ import annotations

import heapq
import itertools
import random
from collections.abc import Callable, Sequence
from functools import partial

from rostether.platform.command_frame import DEFAULT_TTL_MS
from rostether.platform.command_link import (
    CommandReceiver,
    CommandSender,
    ReceiverSettings,
    SenderSettings,
)
from rostether.platform.robot_table import RobotTable, SocketAddress
from rostether.platform.status_reporter import StatusReporter

ROBOTS = 20
LOSS = 0.3
JITTER_S = 0.1
KEY = b"0123456789abcdef"


class Air:
    """The datagrams in transit, by the times of their arrival."""

    def __init__(self) -> None:
        self._random = random.Random(1)
        self._numbers = itertools.count()
        self._events: list[tuple[float, int, Callable[[float], None]]] = []

    def send(self, now_s: float, arrive: Callable[[float], None]) -> None:
        """Deliver after a random time, or never."""
        if self._random.random() >= LOSS:
            self.at(now_s + self._random.uniform(0, JITTER_S), arrive)

    def at(self, time_s: float, action: Callable[[float], None]) -> None:
        heapq.heappush(self._events, (time_s, next(self._numbers), action))

    def run(self, until_s: float) -> None:
        while self._events and self._events[0][0] <= until_s:
            time_s, _, action = heapq.heappop(self._events)
            action(time_s)


class Robot:
    """A receiver that records when it accepted commands and when it stopped."""

    def __init__(self, robot_id: int) -> None:
        self.robot_id = robot_id
        self.link = CommandReceiver(ReceiverSettings(robot_id, key=KEY))
        self.reporter = StatusReporter(robot_id, KEY)
        self.accepted_s: list[float] = []
        self.stopped_s: float | None = None

    def receive(self, datagram: bytes, now_s: float) -> bytes | None:
        if self.link.receive(datagram, now_s) is not None:
            if self.link.is_moving:
                self.accepted_s.append(now_s)
            elif self.stopped_s is None:
                self.stopped_s = now_s
        return self.reporter.answer(self.link, "base:1", now_s)


class Base:
    """A sender that repeats, and sends by unicast to robots that lose too much."""

    def __init__(self, air: Air, robots: Sequence[Robot]) -> None:
        self.air = air
        self.robots = robots
        self.commands = CommandSender(SenderSettings(key=KEY), 1_000)
        self.table = RobotTable(KEY)
        self.is_running = True

    def send(self, datagrams: list[bytes], now_s: float) -> None:
        for datagram in datagrams:
            unicast = {address[1] for address in self.table.unicast_addresses(now_s)}
            for robot in self.robots:
                for _ in range(1 + (robot.robot_id in unicast)):
                    self.air.send(now_s, partial(self._arrive, robot, datagram))
        if self.commands.due_s is not None:
            self.air.at(self.commands.due_s, self._repeat)

    def _repeat(self, now_s: float) -> None:
        if self.is_running and self.commands.due_s is not None and now_s >= self.commands.due_s:
            self.send(self.commands.repeat(now_s), now_s)

    def _arrive(self, robot: Robot, datagram: bytes, now_s: float) -> None:
        status = robot.receive(datagram, now_s)
        if status is not None:
            place: SocketAddress = ("10.0.0.1", robot.robot_id)
            self.air.send(now_s, partial(self._learn, status, place))

    def _learn(self, status: bytes, place: SocketAddress, now_s: float) -> None:
        self.table.receive(status, place, self.commands.epoch_us, now_s)


def test_commands_and_stops_reach_twenty_robots_on_bad_wifi() -> None:
    air = Air()
    robots = [Robot(number) for number in range(1, ROBOTS + 1)]
    base = Base(air, robots)
    base.send(base.commands.command(b"go", 0.0), 0.0)
    air.run(10.0)
    assert len(base.table.robots) == ROBOTS
    assert len(base.table.unicast_addresses(10.0)) == ROBOTS
    gaps = sorted(
        later - earlier for robot in robots for earlier, later in itertools.pairwise(robot.accepted_s)
    )
    assert len(gaps) > 70 * ROBOTS
    assert gaps[len(gaps) * 99 // 100] < 0.25
    base.send(base.commands.stop(10.0), 10.0)
    air.run(11.0)
    assert max(robot.stopped_s or 99.0 for robot in robots) < 10.2


def test_robots_whose_sender_is_killed_stop_within_their_time_to_live() -> None:
    air = Air()
    robots = [Robot(number) for number in range(1, ROBOTS + 1)]
    base = Base(air, robots)
    base.send(base.commands.command(b"go", 0.0), 0.0)
    air.run(1.0)
    base.is_running = False
    air.run(2.0)
    ttl_s = DEFAULT_TTL_MS / 1000
    for robot in robots:
        assert robot.link.deadline_s is not None
        assert robot.link.deadline_s == robot.accepted_s[-1] + ttl_s
        assert robot.accepted_s[-1] < 1.0 + JITTER_S
        assert robot.link.expire(robot.link.deadline_s)
