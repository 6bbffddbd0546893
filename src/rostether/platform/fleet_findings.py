"""Findings about a fleet, from an examination of its robots and from this machine's disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec import Struct

from rostether.mechanisms.text import listed
from rostether.platform.command_channel import duplicate_text
from rostether.platform.fleet_examination import Examination
from rostether.platform.fleet_survey import ClockOffset
from rostether.platform.igmp_querier import QUERY_INTERVAL_S
from rostether.platform.robot_table import MAX_LOSS, Robot, RobotKey, hosts_of_duplicate_ids

# With a weaker signal, Wi-Fi uses its slowest rates, and loses multicast first.
_WEAK_SIGNAL_DBM = -75

# A recording of one camera fills this in a few minutes.
_MIN_FREE_BYTES = 500_000_000

# In this time, a robot at 1 m/s moves 0.1 m: positions of two robots then no longer match.
_MAX_CLOCK_DIFFERENCE_S = 0.1

# A longer line is hard to read, and the remedy is the same for all pairs of robots.
_MAX_LISTED = 5


class FleetFinding(Struct, frozen=True):
    """One line of the report; `what` is the examined part. `is_ok` is None if it could not be checked."""

    is_ok: bool | None
    what: str
    text: str


def fleet_findings(found: Examination, silence_text: str) -> list[FleetFinding]:
    """Return the findings, robots first; `silence_text` is the finding if no robot answers."""
    robots = found.by_unicast | found.by_multicast
    findings = [_robot_finding(key, robots[key], found) for key in sorted(robots)]
    if not robots:
        findings.append(FleetFinding(False, "fleet", silence_text))
    findings += [
        FleetFinding(False, "unicast", f"no robot answers at {host}; check its address and the key")
        for host in found.silent_hosts
        if not any(key.host == host for key in robots)
    ]
    findings += [
        FleetFinding(False, "ids", duplicate_text(robot_id, hosts))
        for robot_id, hosts in hosts_of_duplicate_ids(robots).items()
    ]
    findings += _pair_findings(found.pairs)
    findings += _clock_findings(found.clocks)
    if found.listened_s:
        findings.append(_querier_finding(found))
    return findings


def disk_finding(path: str, free_bytes: int, total_bytes: int) -> FleetFinding:
    """Return the finding about the space for recordings on this machine's disk."""
    text = f"{free_bytes / 1e9:.1f} of {total_bytes / 1e9:.1f} GB are free at {path}"
    if free_bytes < _MIN_FREE_BYTES:
        return FleetFinding(False, "disk", f"{text}; delete old recordings")
    return FleetFinding(True, "disk", text)


def _robot_finding(key: RobotKey, robot: Robot, found: Examination) -> FleetFinding:
    status, host, faults = robot.status, key.host, []
    by_unicast = found.by_unicast.get(key)
    if key not in found.by_multicast and found.asks_group:
        faults.append(
            "unicast arrives, but multicast does not; turn off multicast filtering (or IGMP snooping) in the "
            f"access point and the switches, or send to it with --unicast {host}"
        )
    elif robot.loss is not None and robot.loss > MAX_LOSS:
        unicast = by_unicast.loss if by_unicast is not None else None
        compared = "" if unicast is None else f" of multicast, and {unicast:.0%} of unicast,"
        faults.append(
            f"{robot.loss:.0%}{compared or ' of the datagrams'} are lost; turn off Wi-Fi power saving on the "
            f"robot, or send to it with --unicast {host}"
        )
    if status.signal_dbm is not None and status.signal_dbm < _WEAK_SIGNAL_DBM:
        faults.append(f"the Wi-Fi signal of {status.signal_dbm} dBm is weak; move the access point closer")
    if status.host is not None and status.host.free_bytes < _MIN_FREE_BYTES:
        faults.append(
            f"only {status.host.free_bytes / 1e9:.1f} GB are free on its disk; delete old recordings there"
        )
    loss = "not measured" if robot.loss is None else f"{robot.loss:.0%}"
    text = "; ".join(faults) or f"answers from {host}; loss: {loss}"
    return FleetFinding(not faults, f"robot {status.robot_id}", text)


def _pair_findings(pairs: Sequence[tuple[RobotKey, RobotKey, bool]]) -> list[FleetFinding]:
    """Return the finding about robots that must reach each other, which the base station cannot measure."""
    if not pairs:
        return []
    unreachable = [
        f"robot {first.robot_id} does not reach robot {second.robot_id}"
        for first, second, is_ok in pairs
        if not is_ok
    ]
    if not unreachable:
        return [FleetFinding(True, "robot to robot", "each robot reaches the next one")]
    text = (
        f"{listed(unreachable, _MAX_LISTED)}; turn off client isolation (AP isolation) in the access point, "
        "or the robots cannot share topics without the base station"
    )
    return [FleetFinding(False, "robot to robot", text)]


def _clock_findings(clocks: Mapping[RobotKey, ClockOffset]) -> list[FleetFinding]:
    if not clocks:
        return []
    offsets = {"this machine": ClockOffset(0.0, 0.0)}
    offsets |= {f"robot {key.robot_id} ({key.host})": clocks[key] for key in sorted(clocks)}
    # Rounded, so that this machine is named if clocks are equal.
    ahead = max(offsets, key=lambda name: round(offsets[name].offset_s, 1))
    behind = min(offsets, key=lambda name: round(offsets[name].offset_s, 1))
    difference_s = offsets[ahead].offset_s - offsets[behind].offset_s
    error_s = offsets[ahead].error_s + offsets[behind].error_s
    if difference_s - error_s <= _MAX_CLOCK_DIFFERENCE_S:
        text = (
            f"the clocks of the robots and of this machine differ by at most {difference_s + error_s:.3f} s"
        )
        return [FleetFinding(True, "clocks", text)]
    text = (
        f"the clock of {ahead} is {difference_s:.1f} s ahead of that of {behind}; synchronize all machines, "
        "for example with chrony"
    )
    return [FleetFinding(False, "clocks", text)]


def _querier_finding(found: Examination) -> FleetFinding:
    if found.has_querier is None:
        return FleetFinding(
            None, "IGMP querier", "not checked: listening needs root (sudo) and an existing --interface"
        )
    if found.has_querier:
        return FleetFinding(True, "IGMP querier", "switches and access points know the members of a group")
    if found.listened_s < QUERY_INTERVAL_S:
        return FleetFinding(
            None,
            "IGMP querier",
            f"none in {found.listened_s:g} s; it may be silent for 125 s: listen with "
            f"--duration {QUERY_INTERVAL_S:g}",
        )
    return FleetFinding(
        False,
        "IGMP querier",
        f"none in {found.listened_s:g} s; switches with IGMP snooping forget robots after 2 to 4 minutes. "
        "Turn on the querier of the access point or a switch, or turn off snooping",
    )
