"""A hundred devices and one that floods or sends garbage: lost messages, delays, memory."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.processes import Bench, cpu_s, first_line, output, resident_mb, say, wait_until
from interop.ros1_peers import free_port

FLOOD_TYPE = "std_msgs/String"
ENDLESS = 2_000_000_000
TROUBLE_BYTES_PER_S = 10e6


@dataclass(frozen=True, slots=True)
class Crowd:
    """The measurements of the devices that do not flood; `late_...`: how late they sent their messages."""

    sent: int
    received: int
    p50_ms: float
    p99_ms: float
    longest_ms: float
    resident_mb: float
    cpu_percent: float
    late_p99_ms: float
    late_longest_ms: float


def crowd(
    devices: int, rate_hz: int, seconds: int, *, floods: bool = True, trouble: str = "", roscore: bool = False
) -> Crowd:
    """Serve devices on one listener, and one more that sends as fast as it can.

    `trouble`: instead it sends 10 MB a second of this kind, see crowd_troubles.py. `roscore`: the
    master is Debian's.
    """
    port = free_port()
    messages = rate_hz * seconds
    with Bench(roscore=roscore) as bench:
        # One more device may connect: the one that floods.
        limits = (f"--limit={name}={devices + 1}" for name in ("connections", "connections-per-host"))
        bridge = bench.rostether("serve", f"tcp://:{port}", *limits)
        talkers = bench.module("crowd_devices", str(port), str(devices), str(rate_hz), str(messages))
        first_line(talkers)
        wanted = {f"/crowd{number}" for number in range(devices)}

        def published() -> bool:
            return wanted <= dict(bench.master.getSystemState("/bench")[2][0]).keys()

        wait_until(published, f"{devices} devices", timeout_s=60.0)
        listener = bench.module("crowd_listener", bench.master_uri, str(devices), str(messages))
        first_line(listener)
        if trouble:
            troublemaker = bench.module("crowd_troubles", str(port), trouble, str(TROUBLE_BYTES_PER_S))
            first_line(troublemaker)
            say(troublemaker)
        elif floods:
            flood = bench.module("flood_device", str(port), "send", FLOOD_TYPE, str(ENDLESS))
            bench.wait_for_publisher("/flood")
            say(flood)
        before_s = cpu_s(bridge.pid)
        say(talkers)
        words = output(listener)
        used_s = cpu_s(bridge.pid) - before_s
        late_p99_ms, late_longest_ms = (float(word) for word in first_line(talkers))
        received, p50_ms, p99_ms, longest_ms = int(words[0]), *(float(word) for word in words[1:])
        return Crowd(
            devices * messages,
            received,
            p50_ms,
            p99_ms,
            longest_ms,
            resident_mb(bridge.pid),
            used_s / seconds * 100,
            late_p99_ms,
            late_longest_ms,
        )
