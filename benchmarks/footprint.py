"""The cost of an idle bridge: start time, CPU, memory with one device and with 32."""

from __future__ import annotations

import time
from dataclasses import dataclass

from benchmarks.processes import Bench, cpu_s, first_line, resident_mb, wait_until
from interop.ros1_peers import free_port

IDLE_S = 5.0


@dataclass(frozen=True, slots=True)
class Footprint:
    """Idle CPU in percent of one core, and resident MB."""

    cpu_percent: float
    resident_mb: float


def start_to_first_message_s() -> float:
    """Time from starting `serve` until a waiting roscpp subscriber prints the device's first message.

    roscpp waits twice for its own poll of 0.1 s: before it requests the topic, and before it connects.
    """
    port = free_port()
    with Bench() as bench:
        listener = bench.roscpp("listen", "/flood", "1")

        def waiting() -> bool:
            return any(name == "/flood" for name, _ in bench.master.getSystemState("/bench")[2][1])

        wait_until(waiting, "the subscriber")
        bench.module("talker_device", str(port), "1", "50")
        time.sleep(0.5)
        started = time.perf_counter()
        bench.rostether("serve", f"tcp://:{port}")
        first_line(listener)
        return time.perf_counter() - started


def idle(devices: int) -> Footprint:
    """Serve devices that publish once a second each."""
    port = free_port()
    with Bench() as bench:
        bridge = bench.rostether("serve", f"tcp://:{port}")
        bench.module("talker_device", str(port), str(devices), "1")

        def all_there() -> bool:
            published = dict(bench.master.getSystemState("/bench")[2][0])
            return len(published.get("/flood", [])) == devices

        wait_until(all_there, f"{devices} devices")
        time.sleep(1.0)
        before = cpu_s(bridge.pid)
        time.sleep(IDLE_S)
        return Footprint((cpu_s(bridge.pid) - before) / IDLE_S * 100, resident_mb(bridge.pid))
