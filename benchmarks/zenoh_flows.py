"""The bridge into ROS 2 over zenoh: floods to a subscriber in another process, and round trips."""

from __future__ import annotations

import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import zenoh

from benchmarks import bare_zenoh
from benchmarks.flood_device import PUBLISHER_ID, SUBSCRIBER_ID, announcement, answer_requests, connect
from benchmarks.processes import Bench, cpu_s, first_line, output, say
from benchmarks.round_trip import FRAME_BYTES, PAYLOAD, RoundTrips
from benchmarks.throughput import Flood
from benchmarks.zenoh_listener import open_session, wait_for
from interop.ros1_peers import free_port
from rostether.ros2.zenoh.attachment import Attachment
from rostether.rosserial.frame import encode_frame

TYPE = "std_msgs/String"
LOST_S = 2.0


class ZenohBench(Bench):
    """The processes of one measurement, without a ROS 1 master."""

    def __enter__(self) -> ZenohBench:
        return self


@contextmanager
def _bridged(bench: ZenohBench, name: str) -> Iterator[tuple[subprocess.Popen[str], int, int]]:
    device_port, zenoh_port = free_port(), free_port()
    bridge = bench.module("zenoh_bridge", str(device_port), str(zenoh_port), name)
    if first_line(bridge) != ["serving"]:
        raise RuntimeError("the bridge did not start")
    yield bridge, device_port, zenoh_port


def device_to_ros2(type_name: str, count: int) -> Flood:
    """A TCP device floods, and a zenoh subscriber of another process counts."""
    with ZenohBench() as bench, _bridged(bench, "flood_board") as (bridge, device_port, zenoh_port):
        device = bench.module("flood_device", str(device_port), "send", type_name, str(count))
        listener = bench.module("zenoh_listener", str(zenoh_port), "flood", str(count))
        first_line(listener)
        before = cpu_s(bridge.pid)
        say(device)
        words = output(listener)
        return Flood(count, int(words[0]), float(words[1]), cpu_s(bridge.pid) - before)


class _Peers:
    """The peers in this process: the publisher of `in`, the echoing device, the subscriber of `out`."""

    def __init__(self, stack: ExitStack, device_port: int, zenoh_port: int) -> None:
        self._announcements = announcement(SUBSCRIBER_ID, 1, "in", TYPE)
        self._announcements += announcement(PUBLISHER_ID, 0, "out", TYPE)
        self.device = stack.enter_context(connect(device_port))
        self.device.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.device.settimeout(LOST_S)
        threading.Thread(target=self._echo, daemon=True).start()
        session = stack.enter_context(open_session(str(zenoh_port)))
        self._came = threading.Event()
        self._publisher = session.declare_publisher(wait_for(session, "MS", "in"))
        session.declare_subscriber(
            wait_for(session, "MP", "out"),
            zenoh.handlers.Callback(self._take, indirect=False),
        )
        self._sequence = 0
        time.sleep(1.0)

    def round_trip_s(self) -> float | None:
        """Send one message and wait for its echo; None if it is lost."""
        self._came.clear()
        self._sequence += 1
        attachment = Attachment(self._sequence, time.time_ns(), bytes(16)).encode()
        started = time.perf_counter()
        self._publisher.put(_CDR, attachment=attachment)
        return time.perf_counter() - started if self._came.wait(LOST_S) else None

    def _take(self, _: zenoh.Sample) -> None:
        self._came.set()

    def _echo(self) -> None:
        while True:
            try:
                received = self.device.recv(65536)
            except TimeoutError:
                continue
            except OSError:
                return
            if not received:
                return
            answer_requests(self.device, self._announcements, received)
            at = received.find(_FRAME_START)
            if at >= 0 and len(received) >= at + FRAME_BYTES:
                self.device.sendall(encode_frame(PUBLISHER_ID, received[at + 7 : at + 7 + len(PAYLOAD)]))


_FRAME_START = encode_frame(SUBSCRIBER_ID, PAYLOAD)[:7]
# The same String in CDR: its length counts the NUL at its end.
_CDR = b"\0\1\0\0" + struct.pack("<I", len(PAYLOAD) - 3) + b"x" * (len(PAYLOAD) - 4) + b"\0"


def round_trips(rate_hz: float, count: int) -> RoundTrips:
    """Send `count` 64-byte messages at `rate_hz` and measure each round trip."""
    with (
        ZenohBench() as bench,
        _bridged(bench, "echo_board") as (_, device_port, zenoh_port),
        ExitStack() as stack,
    ):
        return _timed(_Peers(stack, device_port, zenoh_port).round_trip_s, rate_hz, count)


def bare_round_trips(rate_hz: float, count: int) -> RoundTrips:
    """Measure the same round trip through a process that only passes bytes on: the time of the library."""
    device_port, zenoh_port = free_port(), free_port()
    came = threading.Event()

    def take(_: zenoh.Sample) -> None:
        came.set()

    with ZenohBench() as bench, ExitStack() as stack:
        if first_line(bench.module("bare_zenoh", str(device_port), str(zenoh_port))) != ["serving"]:
            raise RuntimeError("the process that passes bytes on did not start")
        device = stack.enter_context(socket.create_connection(("127.0.0.1", device_port)))
        device.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        threading.Thread(target=_echo_bytes, args=(device,), daemon=True).start()
        session = stack.enter_context(open_session(str(zenoh_port)))
        session.declare_subscriber(bare_zenoh.OUT, zenoh.handlers.Callback(take, indirect=False))
        publisher = session.declare_publisher(bare_zenoh.IN)
        time.sleep(1.0)

        def round_trip_s() -> float | None:
            came.clear()
            started = time.perf_counter()
            publisher.put(_CDR)
            return time.perf_counter() - started if came.wait(LOST_S) else None

        return _timed(round_trip_s, rate_hz, count)


def _echo_bytes(device: socket.socket) -> None:
    try:
        while data := device.recv(65536):
            device.sendall(data)
    except OSError:
        return


def _timed(round_trip_s: Callable[[], float | None], rate_hz: float, count: int) -> RoundTrips:
    times: list[float] = []
    started = time.perf_counter()
    for index in range(count):
        taken_s = round_trip_s()
        if taken_s is not None:
            times.append(taken_s)
        time.sleep(max(0.0, started + (index + 1) / rate_hz - time.perf_counter()))
    return RoundTrips(count, tuple(sorted(times)))
