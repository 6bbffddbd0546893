"""Four robots with faults, each on a separate machine, and the doctor on another; test_fleet_doctor runs it.

One process has the sockets of all machines: a socket stays in the network namespace where it was opened.
Prints the output of `fleet doctor --json` and then, after a line of input, whether a querier is found.
"""

from __future__ import annotations

import asyncio
import ctypes
import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from msgspec.structs import replace

from rostether.cli.platform.fleet import examine_fleet
from rostether.platform.command_link import ReceiverSettings, SenderSettings
from rostether.platform.fleet import FleetSettings
from rostether.platform.host_state import read_host
from rostether.platform.igmp_querier import has_querier
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.status_frame import HostState
from unit.platform.typed_nodes import Lines, typed_nodes

KEY = b"0123456789abcdef"
GROUP = GroupAddress("239.255.82.83", 11412)
_NETWORK_NAMESPACE = 0x40000000


def enter(machine: str) -> None:
    """Open the next sockets on a machine."""
    with Path("/run/netns", machine).open() as namespace:
        assert ctypes.CDLL(None).setns(namespace.fileno(), _NETWORK_NAMESPACE) == 0


def fast_clock() -> HostState:
    """Return the state of a machine whose clock is 5 s ahead."""
    here = read_host()
    return replace(here, clock_us=here.clock_us + 5_000_000)


async def main(full_disk: Path) -> None:
    """Start the robots, and examine them."""
    _, (node,) = await typed_nodes("/receivers")
    lines, robots = Lines(), []
    states: list[Callable[[], HostState]] = [fast_clock, partial(read_host, full_disk), read_host, read_host]
    for index, (number, state) in enumerate(zip((1, 2, 3, 1), states, strict=True), 1):
        enter(f"robot{index}")
        settings = ReceiverNodeSettings(
            "std_msgs/Bool",
            f"robot{index}",
            # An address, because a name would be resolved on another machine when the join is repeated.
            replace(GROUP, interfaces=(f"10.77.0.{index + 1}",)),
            framed=ReceiverSettings(number, key=KEY),
            has_key=True,
        )
        robots.append(asyncio.create_task(receive_topic(node, settings, lines, state)))
        while len(lines.texts) < index:
            await asyncio.sleep(0)
    enter("base")
    fleet = FleetSettings(
        SenderSettings(key=KEY), replace(GROUP, interfaces=("net",)), ("10.77.0.4", "10.77.0.99")
    )
    await examine_fleet(fleet, 1.0, as_json=True)
    # No robot reports or refuses anything.
    assert len(lines.texts) == len(robots), lines.texts
    sys.stdin.readline()
    print(json.dumps({"has_querier": await has_querier(("net",), 60.0)}))
    for robot in robots:
        robot.cancel()


asyncio.run(main(Path(sys.argv[1])))
