"""The cost of the Foxglove and rosbridge gateways for a client of many topics, in one run.

Each is measured in several short turns, so that other work of the machine affects all of them.
"""

from __future__ import annotations

import os
import socket
import statistics
import subprocess
import time
from dataclasses import dataclass

from benchmarks.processes import Bench, cpu_s, first_line, output, say, wait_until
from interop.ros1_peers import free_port

TOPICS = 50
RATE_HZ = 100.0
SECONDS = 3.0
TURNS = 3
KINDS = {"foxglove": "foxglove", "json": "rosbridge", "cbor-raw": "rosbridge"}
"""The encoding that a client requests, and the verb of its gateway."""


@dataclass(frozen=True, slots=True)
class GatewayCost:
    """One gateway's processor time (of the median turn), and the messages of its client in all turns."""

    received: int
    expected: int
    cpu_percent: float


def gateway_costs() -> dict[str, GatewayCost]:
    """Measure each kind of `KINDS`; the client receives all topics."""
    received = dict.fromkeys(KINDS, 0)
    cpu: dict[str, list[float]] = {kind: [] for kind in KINDS}
    with Bench() as bench:
        os.environ["ROS_MASTER_URI"] = bench.master_uri
        first_line(bench.module("many_topics", str(TOPICS), str(RATE_HZ)))
        gateways = {verb: _gateway(bench, verb) for verb in dict.fromkeys(KINDS.values())}
        for _ in range(TURNS):
            for kind, verb in KINDS.items():
                process, port = gateways[verb]
                client = bench.module("gateway_listener", str(port), str(TOPICS), kind, str(SECONDS))
                first_line(client)
                before_s, began_s = cpu_s(process.pid), time.monotonic()
                say(client)
                received[kind] += int(output(client)[0])
                passed_s = time.monotonic() - began_s
                cpu[kind].append(100 * (cpu_s(process.pid) - before_s) / passed_s)
    expected = int(TOPICS * RATE_HZ * SECONDS * TURNS)
    return {kind: GatewayCost(received[kind], expected, statistics.median(cpu[kind])) for kind in KINDS}


def _gateway(bench: Bench, verb: str) -> tuple[subprocess.Popen[str], int]:
    port = free_port()
    process = bench.rostether(verb, str(port))
    wait_until(lambda: _listens(port), f"the gateway {verb}")
    return process, port


def _listens(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
    except OSError:
        return False
    return True
