"""What a gateway costs whose client listens to many topics: Foxglove's and rosbridge's, in one run."""

from __future__ import annotations

import os
import socket
import time
from dataclasses import dataclass

from benchmarks.processes import Bench, cpu_s, first_line, output, say, wait_until
from interop.ros1_peers import free_port

TOPICS = 50
RATE_HZ = 100.0
SECONDS = 5.0


@dataclass(frozen=True, slots=True)
class GatewayCost:
    """One gateway's processor time, and what its client got."""

    received: int
    expected: int
    cpu_percent: float


def gateway_cost(kind: str) -> GatewayCost:
    """Measure `foxglove`, or rosbridge with `json` or `cbor-raw`; its client hears all topics."""
    verb = "foxglove" if kind == "foxglove" else "rosbridge"
    with Bench() as bench:
        os.environ["ROS_MASTER_URI"] = bench.master_uri
        robot = bench.module("many_topics", str(TOPICS), str(RATE_HZ))
        first_line(robot)
        port = free_port()
        gateway = bench.ours(verb, str(port))
        wait_until(lambda: _listens(port), f"the gateway {verb}")
        client = bench.module("gateway_listener", str(port), str(TOPICS), kind, str(SECONDS))
        first_line(client)
        before_s, began_s = cpu_s(gateway.pid), time.monotonic()
        say(client)
        received = int(output(client)[0])
        used_s, passed_s = cpu_s(gateway.pid) - before_s, time.monotonic() - began_s
        return GatewayCost(received, int(TOPICS * RATE_HZ * SECONDS), 100 * used_s / passed_s)


def _listens(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
    except OSError:
        return False
    return True
