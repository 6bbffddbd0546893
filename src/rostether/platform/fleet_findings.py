"""What is wrong with a fleet, from the robots' answers and this machine's disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rostether.platform.command_channel import duplicate_text
from rostether.platform.robot_table import MAX_LOSS, Robot

# Below, Wi-Fi falls back to its slowest rates and loses multicast first.
WEAK_SIGNAL_DBM = -75

# A recording of one camera fills this in some minutes.
_LEAST_FREE_BYTES = 500_000_000


@dataclass(frozen=True, slots=True)
class FleetFinding:
    """One line of the report; `what` is what was examined."""

    is_well: bool
    what: str
    text: str


def fleet_findings(
    robots: Sequence[Robot], duplicate_ids: Mapping[int, list[str]], silence_text: str
) -> list[FleetFinding]:
    """Return a finding for each robot and each id that two robots have; `silence_text` is for no robot."""
    if not robots:
        return [FleetFinding(False, "fleet", silence_text)]
    doubled = [
        FleetFinding(False, "ids", duplicate_text(robot_id, hosts))
        for robot_id, hosts in duplicate_ids.items()
    ]
    return [*map(_robot_finding, robots), *doubled]


def disk_finding(path: str, free_bytes: int, total_bytes: int) -> FleetFinding:
    """Return whether recordings fit on this machine's disk."""
    text = f"{free_bytes / 1e9:.1f} of {total_bytes / 1e9:.1f} GB are free at {path}"
    if free_bytes < _LEAST_FREE_BYTES:
        return FleetFinding(False, "disk", f"{text}; delete old recordings")
    return FleetFinding(True, "disk", text)


def _robot_finding(robot: Robot) -> FleetFinding:
    status, faults = robot.status, []
    if robot.loss is not None and robot.loss > MAX_LOSS:
        faults.append(
            f"{robot.loss:.0%} of the datagrams are lost; turn off Wi-Fi power saving on the robot, or send "
            f"to it by --unicast {robot.address[0]}"
        )
    if status.signal_dbm is not None and status.signal_dbm < WEAK_SIGNAL_DBM:
        faults.append(f"the Wi-Fi signal of {status.signal_dbm} dBm is weak; move the access point closer")
    loss = "not measured" if robot.loss is None else f"{robot.loss:.0%}"
    text = "; ".join(faults) or f"answers from {robot.address[0]}; loss: {loss}"
    return FleetFinding(not faults, f"robot {status.robot_id}", text)
