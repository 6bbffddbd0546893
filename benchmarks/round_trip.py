"""ROS to device and back: single messages at a fixed rate, through an echoing TCP device."""

from __future__ import annotations

import asyncio
import contextlib
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.processes import Bench
from interop.ros1_peers import free_port
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import join_ros1


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


async def _measure(bench: Bench, rate_hz: float, count: int) -> RoundTrips:
    graph = await join_ros1("bench", environment=RosEnvironment.read({"ROS_MASTER_URI": bench.master_uri}))
    text = Registry().message_type("std_msgs/String")
    times: list[float] = []
    all_back = asyncio.Event()
    connected = asyncio.Event()

    def on_messages(payloads: Sequence[bytes]) -> None:
        now = time.perf_counter()
        times.extend(now - struct.unpack_from("<d", payload, 4)[0] for payload in payloads)
        if len(times) >= count:
            all_back.set()

    publisher = await graph.advertise("/in", text)
    await graph.subscribe("/out", text, on_messages, on_connection=lambda _: connected.set())
    await connected.wait()
    while publisher.subscriber_count == 0:
        await asyncio.sleep(0.01)
    await asyncio.sleep(0.2)
    started = time.perf_counter()
    for index in range(count):
        publisher.publish_raw([struct.pack("<Id52x", 60, time.perf_counter())])
        await asyncio.sleep(max(0.0, started + (index + 1) / rate_hz - time.perf_counter()))
    with contextlib.suppress(TimeoutError):
        await asyncio.wait_for(all_back.wait(), 2.0)
    await graph.close()
    return RoundTrips(count, tuple(sorted(times)))


def round_trips(rate_hz: float, count: int) -> RoundTrips:
    """Send `count` 64-byte messages at `rate_hz` and time each one's way back."""
    port = free_port()
    with Bench() as bench:
        bench.ours("serve", f"tcp://:{port}?name=echo_board")
        bench.module("flood_device", str(port), "echo")
        bench.wait_for_publisher("/out")
        return asyncio.run(_measure(bench, rate_hz, count))
