"""Messages a second through the bridge in each direction, compared with a bare relay in the same run."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.processes import Bench, cpu_s, first_line, output, say, wait_until
from interop.ros1_peers import free_port

SIZES = {"std_msgs/String": 64, "sensor_msgs/Imu": 316, "sensor_msgs/CompressedImage": 4096}


@dataclass(frozen=True, slots=True)
class Flood:
    """One measured flood."""

    sent: int
    received: int
    seconds: float
    bridge_cpu_s: float

    @property
    def rate_hz(self) -> float:
        """Messages a second that arrived."""
        return self.received / self.seconds if self.seconds else 0.0

    @property
    def cpu_per_100k_s(self) -> float:
        """CPU seconds of the bridge for 100,000 messages."""
        return self.bridge_cpu_s / max(self.received, 1) * 100_000


def device_to_ros(type_name: str, count: int) -> Flood:
    """A TCP device floods, and a roscpp subscriber counts."""
    port = free_port()
    with Bench() as bench:
        bridge = bench.rostether("serve", f"tcp://:{port}?name=flood_board")
        device = bench.module("flood_device", str(port), "send", type_name, str(count))
        bench.wait_for_publisher("/flood")
        counter = bench.roscpp("count", "/flood", str(count), "3")
        bench.wait_for_connection("/flood_board", "/flood")
        before = cpu_s(bridge.pid)
        say(device)
        words = output(counter)
        return Flood(count, int(words[0]), float(words[2]), cpu_s(bridge.pid) - before)


def ros_to_device(count: int) -> Flood:
    """A roscpp publisher floods, and a TCP device counts."""
    port = free_port()
    with Bench() as bench:
        bridge = bench.rostether("serve", f"tcp://:{port}?name=flood_board")
        device = bench.module("flood_device", str(port), "sink", str(count))

        def subscribed() -> bool:
            return any(name == "/flood" for name, _ in bench.master.getSystemState("/bench")[2][1])

        wait_until(subscribed, "the bridge's subscription")
        before = cpu_s(bridge.pid)
        bench.roscpp("flood", "/flood", str(count), "64", "0", "0.3")
        words = output(device)
        return Flood(count, int(words[0]), float(words[1]), cpu_s(bridge.pid) - before)


def relay_to_ros(type_name: str, count: int) -> Flood:
    """The limit of device_to_ros: the same bytes, copied."""
    port = free_port()
    with Bench() as bench:
        relay = bench.module("bare_relay", bench.master_uri, "out", str(port), "/flood", type_name)
        bench.wait_for_publisher("/flood")
        source = bench.module("tcpros_source", str(port), type_name, str(count))
        counter = bench.roscpp("count", "/flood", str(count), "3")
        first_line(source)
        wait_until(lambda: cpu_s(relay.pid) > 0, "the relay")
        before = cpu_s(relay.pid)
        say(source)
        words = output(counter)
        return Flood(count, int(words[0]), float(words[2]), cpu_s(relay.pid) - before)


def relay_from_ros(count: int) -> Flood:
    """The limit of ros_to_device: the same bytes, copied."""
    port = free_port()
    with Bench() as bench:
        bench.roscpp("flood", "/flood", str(count), "64", "0", "0.3")
        bench.wait_for_publisher("/flood")
        relay = bench.module("bare_relay", bench.master_uri, "in", str(port), "/flood", "std_msgs/String")
        before = cpu_s(relay.pid)
        sink = bench.module("tcpros_source", str(port), "sink", str(count))
        words = output(sink)
        return Flood(count, int(words[0]), float(words[1]), cpu_s(relay.pid) - before)
