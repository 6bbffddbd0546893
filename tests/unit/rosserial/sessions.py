"""A host link and a device link on a simulated line: its speed, its losses and its clock are the test's."""

from __future__ import annotations

import heapq
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from rostether.rosserial.device_link import DeviceLink
from rostether.rosserial.events import DeviceEvent, HostEvent, TimeRequested
from rostether.rosserial.frame import FORMS
from rostether.rosserial.host_link import HostLink
from rostether.rostime import Time

EPOCH_S = 1_700_000_000.0
STRING = "std_msgs/String"
STRING_MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
EMPTY = "std_msgs/Empty"
EMPTY_MD5 = "d41d8cd98f00b204e9800998ecf8427e"
TEST_SRV = "rosserial_arduino/Test"
TEST_REQUEST_MD5 = "39e92f1778057359c64c7b8a7d7b19de"
TEST_RESPONSE_MD5 = "0825d95fdfa2c8f4bbb4e9c74bccd3fd"

Manipulator = Callable[[bytes], bytes]


def pass_unharmed(frame: bytes) -> bytes:
    return frame


def lose_or_damage(rng: random.Random, probability: float) -> Manipulator:
    """Lose a frame, or change, cut out or insert some of its bytes, with this probability."""

    def manipulate(frame: bytes) -> bytes:
        if rng.random() >= probability:
            return frame
        how = rng.randrange(4)
        damaged = bytearray(frame)
        if how == 0:
            return b""
        if how == 1:
            for _ in range(rng.randint(1, 4)):
                damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        elif how == 2:
            start = rng.randrange(len(damaged))
            del damaged[start : start + rng.randint(1, len(damaged))]
        else:
            start = rng.randrange(len(damaged))
            damaged[start:start] = rng.randbytes(rng.randint(1, 8))
        return bytes(damaged)

    return manipulate


def split_frames(data: bytes) -> Iterator[bytes]:
    """Cut what a link sends into frames; bytes outside frames (probes, guards) come one run at a time."""
    position = 0
    while position < len(data):
        if data[position : position + 2] == b"\xff\xfe":
            size = int.from_bytes(data[position + 2 : position + 4], "little") + FORMS[2].overhead_bytes
        elif data[position : position + 2] == b"\xff\xff":
            size = int.from_bytes(data[position + 4 : position + 6], "little") + FORMS[1].overhead_bytes
        else:
            size = max(data.find(b"\xff", position + 1), position + 1) - position
        yield data[position : position + size]
        position += size


@dataclass
class Line:
    """Drives both links; `run_until` moves the clock from event to event."""

    host: HostLink
    device: DeviceLink
    baud: float = float("inf")
    latency_s: float = 0.001
    to_host: Manipulator = pass_unharmed
    to_device: Manipulator = pass_unharmed
    answers_time: bool = True
    spin_period_s: float = 0.0
    now_s: float = 100.0
    host_events: list[tuple[float, HostEvent]] = field(default_factory=list)
    device_events: list[tuple[float, DeviceEvent]] = field(default_factory=list)
    sent_by_host: bytearray = field(default_factory=bytearray)
    sent_by_device: bytearray = field(default_factory=bytearray)
    device_is_on: bool = True

    def __post_init__(self) -> None:
        self._queue: list[tuple[float, int, bool, bytes]] = []
        self._order = 0
        self._free_s = {True: 0.0, False: 0.0}

    def start(self) -> None:
        self.device.start(self.now_s)
        self.host.start(self.now_s)
        self.flush()

    def reset_device(self) -> None:
        """Reset the board: what it had not sent is lost."""
        self.device.start(self.now_s)

    def run_until(self, condition: Callable[[], bool], limit_s: float) -> bool:
        """Run until the condition holds; False when `limit_s` of link time have passed before."""
        end_s = self.now_s + limit_s
        while not condition():
            if not self.step(end_s):
                self.now_s = end_s
                return False
        return True

    def run(self, seconds: float) -> None:
        """Let this much link time pass."""
        self.run_until(lambda: False, seconds)

    def step(self, end_s: float = float("inf")) -> bool:
        """Do what happens next, unless that is after `end_s`."""
        timers = [self.host.get_timer(), self.device.get_timer() if self.device_is_on else None]
        if self._queue:
            timers.append(self._queue[0][0])
        due_s = min((timer for timer in timers if timer is not None), default=float("inf"))
        if due_s > end_s:
            return False
        self.now_s = max(self.now_s, due_s)
        while self._queue and self._queue[0][0] <= self.now_s:
            _, _, is_to_host, data = heapq.heappop(self._queue)
            if is_to_host:
                self.take_host_events(self.host.receive_data(data, self.now_s))
            elif self.device_is_on:
                self.take_device_events(self.device.receive_data(data, self.now_s))
        self.take_host_events(self.host.handle_timer(self.now_s))
        if self.device_is_on:
            self.take_device_events(self.device.handle_timer(self.now_s))
        self.flush()
        return True

    def take_host_events(self, events: list[HostEvent]) -> None:
        for event in events:
            self.host_events.append((self.now_s, event))
            if isinstance(event, TimeRequested) and self.answers_time:
                self.host.answer_time(Time.from_s(EPOCH_S + self.now_s), self.now_s)

    def take_device_events(self, events: list[DeviceEvent]) -> None:
        self.device_events += [(self.now_s, event) for event in events]

    def flush(self) -> None:
        """Put on the line what both links want to send."""
        self.send_to_device(self.host.data_to_send())
        data = self.device.data_to_send()
        if self.device_is_on:
            self.send_to_host(data)

    def send_to_device(self, data: bytes) -> None:
        self.sent_by_host += data
        self._put(data, is_to_host=False)

    def send_to_host(self, data: bytes) -> None:
        self.sent_by_device += data
        self._put(data, is_to_host=True)

    def events_of(self, *kinds: type) -> list[HostEvent]:
        return [event for _, event in self.host_events if isinstance(event, kinds)]

    def _put(self, data: bytes, *, is_to_host: bool) -> None:
        manipulate = self.to_host if is_to_host else self.to_device
        free_s = max(self._free_s[is_to_host], self.now_s)
        for frame in split_frames(data):
            free_s += 10 * len(frame) / self.baud
            arrival_s = free_s + self.latency_s
            if not is_to_host and self.spin_period_s:
                arrival_s = -(-arrival_s // self.spin_period_s) * self.spin_period_s
            arrived = manipulate(frame)
            if arrived:
                self._order += 1
                heapq.heappush(self._queue, (arrival_s, self._order, is_to_host, arrived))
        self._free_s[is_to_host] = free_s


def declare_many(device: DeviceLink, publishers: int, subscribers: int, services: int) -> None:
    """Declare this many of each; `services` of both kinds, whose requests and responses are additional."""
    for number in range(publishers):
        device.add_publisher(f"sensor_{number}/state", STRING, STRING_MD5)
    for number in range(subscribers):
        device.add_subscriber(f"actuator_{number}/command", EMPTY, EMPTY_MD5)
    for number in range(services):
        device.add_service_server(f"serve_{number}", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
        device.add_service_client(f"call_{number}", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
