"""ROS to device and back: the round-trip times of single messages at a fixed rate.

Publisher, device and subscriber are one program with blocking sockets, so that the time is that of the bridge
and the system: twice through the bridge, four wake-ups.
"""

from __future__ import annotations

import socket
import struct
import time
import xmlrpc.client
from dataclasses import dataclass
from typing import Any

from benchmarks.bare_relay import header, listen, read_header, slave
from benchmarks.flood_device import PUBLISHER_ID, SUBSCRIBER_ID, announcement, answer_requests, connect
from benchmarks.processes import Bench
from interop.ros1_peers import free_port
from rostether.msgdef.registry import Registry
from rostether.rosserial.frame import encode_frame

TYPE = "std_msgs/String"
PAYLOAD = struct.pack("<I60x", 60)
FRAME_BYTES = len(PAYLOAD) + 8
SETTLE_S = 1.0


@dataclass(frozen=True, slots=True)
class RoundTrips:
    """Round-trip times of one run, sorted, in seconds; `sent` minus their number were lost."""

    sent: int
    times_s: tuple[float, ...]

    def percentile_ms(self, percent: float) -> float:
        """Return a percentile in milliseconds."""
        if not self.times_s:
            return float("inf")
        return self.times_s[min(int(len(self.times_s) * percent / 100), len(self.times_s) - 1)] * 1000


class Peers:
    """The three peers: the publisher of `in`, the device that echoes, the subscriber of `out`."""

    def __init__(self, bench: Bench, port: int) -> None:
        self._announcements = announcement(SUBSCRIBER_ID, 1, "in", TYPE)
        self._announcements += announcement(PUBLISHER_ID, 0, "out", TYPE)
        self.device = connect(port)
        self.device.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._negotiate()
        bench.wait_for_publisher("/out")
        master: Any = bench.master
        md5sum = Registry().message_type(TYPE).md5sum
        server = listen()
        uri = slave(server.getsockname()[1])
        master.registerPublisher("/bench", "/in", TYPE, uri)
        self.publisher, _ = server.accept()
        self.publisher.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        read_header(self.publisher)
        self.publisher.sendall(
            header(
                callerid="/bench", md5sum=md5sum, type=TYPE, latching="0", message_definition="string data\n"
            )
        )
        bridge: Any = xmlrpc.client.ServerProxy(master.registerSubscriber("/bench", "/out", TYPE, uri)[2][0])
        _, _, (_, host, tcpros_port) = bridge.requestTopic("/bench", "/out", [["TCPROS"]])
        self.subscriber = socket.create_connection((host, tcpros_port))
        self.subscriber.sendall(
            header(callerid="/bench", topic="/out", md5sum=md5sum, type=TYPE, tcp_nodelay="1")
        )
        read_header(self.subscriber)

    def _negotiate(self) -> None:
        ends_s = time.monotonic() + SETTLE_S
        self.device.settimeout(0.05)
        while time.monotonic() < ends_s:
            try:
                answer_requests(self.device, self._announcements, self.device.recv(65536))
            except TimeoutError:
                continue
        self.device.settimeout(2.0)

    def round_trip_s(self) -> float:
        """Send one message and wait for its echo. Raises TimeoutError if it is lost."""
        started = time.perf_counter()
        self.publisher.sendall(struct.pack("<I", len(PAYLOAD)) + PAYLOAD)
        received = b""
        while len(received) < FRAME_BYTES or received[5] != SUBSCRIBER_ID:
            received = self.device.recv(65536)
            answer_requests(self.device, self._announcements, received)
        self.device.sendall(encode_frame(PUBLISHER_ID, received[7 : 7 + len(PAYLOAD)]))
        size = 0
        while size < len(PAYLOAD) + 4:
            size += len(self.subscriber.recv(65536))
        return time.perf_counter() - started


def round_trips(rate_hz: float, count: int) -> RoundTrips:
    """Send `count` 64-byte messages at `rate_hz` and measure each round trip."""
    port = free_port()
    with Bench() as bench:
        bench.rostether("serve", f"tcp://:{port}?name=echo_board")
        peers = Peers(bench, port)
        peers.subscriber.settimeout(2.0)
        times: list[float] = []
        started = time.perf_counter()
        for index in range(count):
            try:
                times.append(peers.round_trip_s())
            except TimeoutError:
                continue
            time.sleep(max(0.0, started + (index + 1) / rate_hz - time.perf_counter()))
        return RoundTrips(count, tuple(sorted(times)))
