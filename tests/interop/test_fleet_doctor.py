"""`rostether doctor --fleet` finds faults of the network that the kernel simulates."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from interop.machines import machines, missing_namespaces

TESTS = Path(__file__).parents[1]


@pytest.mark.skipif(bool(missing_namespaces()), reason=missing_namespaces())
def test_faults_of_robots_and_of_their_network(tmp_path: Path) -> None:
    with machines("base", "robot1", "robot2", "robot3", "robot4") as network:
        # The settings of an access point with client isolation, and of one that blocks multicast.
        network.switch("switch type bridge mcast_snooping 0")
        network.switch("to_robot2 type bridge_slave isolated on")
        network.switch("to_robot3 type bridge_slave isolated on mcast_flood off")
        full = "mount -t tmpfs -o size=1m none $0 && exec $@"
        with subprocess.Popen(
            [
                *network.on("base"),
                *("unshare", "--mount", "sh", "-c", full, tmp_path),
                *(sys.executable, "-m", "interop.fleet_of_namespaces", tmp_path),
            ],
            env={**os.environ, "PYTHONPATH": str(TESTS)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as process:
            assert process.stdout is not None
            findings: list[dict[str, object]] = []
            while not findings or findings[-1]["what"] != "disk":
                findings.append(json.loads(process.stdout.readline()))
            network.switch("switch type bridge mcast_snooping 1 mcast_startup_query_interval 10")
            network.switch("switch type bridge mcast_querier 1 mcast_query_interval 50")
            later, _ = process.communicate("\n", timeout=60)
    expected = [
        ("robot 1", True, "answers from 10.77.0.2; loss: "),
        ("robot 1", True, "answers from 10.77.0.5; loss: "),
        ("robot 2", False, "only 0.0 GB are free on its disk"),
        ("robot 3", False, "unicast arrives, but multicast does not"),
        ("unicast", False, "no robot answers at 10.77.0.99"),
        ("ids", False, "2 robots have the id 1: 10.77.0.2, 10.77.0.5"),
        ("robot to robot", False, "robot 2 does not reach robot 3; turn off client isolation"),
        ("clocks", False, "the clock of robot 1 (10.77.0.2) is N s ahead of that of this machine"),
        ("IGMP querier", None, "none in 4 s"),
    ]
    for (what, is_ok, begin), found in zip(expected, findings[:-1], strict=True):
        assert (found["what"], found["ok"]) == (what, is_ok)
        text = str(found["text"])
        if what == "clocks":
            # The error is the time of an answer, which is longer on a busy machine.
            ahead = re.search(r"[\d.]+(?= s ahead)", text)
            assert ahead is not None
            assert abs(float(ahead[0]) - 5.0) < 1.0
            text = text.replace(ahead[0], "N", 1)
        assert text.startswith(begin)
    assert json.loads(later) == {"has_querier": True}
