"""Measures what `rostether doctor --fleet` reports: losses, clocks, robots that do not reach each other."""

from __future__ import annotations

import asyncio
import socket
import time
from contextlib import closing

from msgspec import Struct, field
from msgspec.structs import replace

from rostether.graph.ports import Report
from rostether.platform.command_channel import MAX_UNICAST
from rostether.platform.command_frame import NO_KEY, encode_forward
from rostether.platform.command_link import CommandSender, SenderSettings
from rostether.platform.datagram_sender import DatagramSender
from rostether.platform.fleet import QUERY_S, FleetSettings
from rostether.platform.fleet_survey import ClockOffset, Survey
from rostether.platform.igmp_querier import has_querier
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.robot_table import Robot, RobotKey

# Enough for many queries and answers; a working Wi-Fi network loses few of them.
_UNICAST_S = 1.5
# The number of queries for forwarding to each robot, and their interval.
_FORWARD_COUNT = 5
_FORWARD_PERIOD_S = 0.05
# Statuses come every 250 ms, and the first one ends the wait.
_CONFIRM_S = 3.0


class Examination(Struct):
    """The measurements. Robots are identified by id and host.

    `asks_group` is False for a fleet without multicast. `silent_hosts` are the configured addresses at which
    no robot answers. `pairs` are pairs of robots, and whether the first reaches the second. `has_querier`
    is None if this machine may not listen; `listened_s` is 0 if the fleet needs no querier.
    """

    asks_group: bool
    by_multicast: dict[RobotKey, Robot] = field(default_factory=dict)
    by_unicast: dict[RobotKey, Robot] = field(default_factory=dict)
    silent_hosts: list[str] = field(default_factory=list)
    clocks: dict[RobotKey, ClockOffset] = field(default_factory=dict)
    pairs: list[tuple[RobotKey, RobotKey, bool]] = field(default_factory=list)
    has_querier: bool | None = None
    listened_s: float = 0.0


async def examine(settings: FleetSettings, report: Report, listen_s: float) -> Examination:
    """Measure for about five seconds, and listen for a querier for at least `listen_s`.

    Raises ConfigError for an invalid address.
    """
    address = settings.address.checked()
    found = Examination(address.is_multicast)
    # IPv6 has another protocol for this, MLD.
    if address.is_multicast and address.family is socket.AF_INET:
        found.listened_s = max(listen_s, QUERY_S + _UNICAST_S)
    querier = asyncio.create_task(has_querier(address.interfaces, found.listened_s))
    try:
        group = Survey(settings.sender, address, report)
        await group.run(QUERY_S)
        found.by_multicast, found.clocks = group.robots, group.clocks
        await _ask_by_unicast(found, settings, group.robots, report)
        if settings.sender.key != NO_KEY:
            found.pairs = await _ask_neighbors(settings.sender, found.by_unicast, report)
        found.has_querier = await querier
    finally:
        querier.cancel()
    return found


async def _ask_by_unicast(
    found: Examination,
    settings: FleetSettings,
    robots: dict[RobotKey, Robot],
    report: Report,
) -> None:
    """Ask the robots that answered, and the addresses that were given."""
    addresses = [robot.address[:2] for robot in robots.values()]
    hosts = {host for host, _ in addresses}
    addresses += [(host, settings.address.port) for host in settings.unicast if host not in hosts]
    surveys = {
        (host, port): Survey(settings.sender, GroupAddress(host, port), report)
        for host, port in addresses[:MAX_UNICAST]
    }
    await asyncio.gather(*[survey.run(_UNICAST_S) for survey in surveys.values()])
    for (host, _), survey in surveys.items():
        found.by_unicast |= survey.robots
        for key, clock in survey.clocks.items():
            known = found.clocks.get(key)
            if known is None or clock.error_s < known.error_s:
                found.clocks[key] = clock
        if not survey.robots:
            found.silent_hosts.append(host)


async def _ask_neighbors(
    sender: SenderSettings, robots: dict[RobotKey, Robot], report: Report
) -> list[tuple[RobotKey, RobotKey, bool]]:
    """Let each robot send a query to the next one, the last one to the first. Boards cannot forward."""
    # A link-local IPv6 address (with %) has another scope on each machine.
    forwarders = [
        each for each in robots.values() if each.status.host is not None and "%" not in each.key.host
    ]
    if len(forwarders) < 2:
        return []
    forwarders.sort(key=lambda robot: robot.key)
    ring = list(zip(forwarders, [*forwarders[1:], forwarders[0]], strict=True))
    epoch_us = time.time_ns() // 1000
    # Each pair has its own epoch: a robot counts the frames of an epoch.
    reached = await asyncio.gather(
        *[_reaches(sender, *pair, epoch_us + index, report) for index, pair in enumerate(ring)]
    )
    return [
        (first.key, second.key, is_reached)
        for (first, second), is_reached in zip(ring, reached, strict=True)
        if is_reached is not None
    ]


async def _reaches(
    sender: SenderSettings, first: Robot, second: Robot, epoch_us: int, report: Report
) -> bool | None:
    """Return whether the first robot reaches the second one; None if the second does not answer now."""
    host, port = second.address[:2]
    to_first = replace(sender, target=first.status.robot_id, to_groups=False)
    to_second = replace(sender, target=second.status.robot_id, to_groups=False)
    outer, inner = CommandSender(to_first, epoch_us), CommandSender(to_second, epoch_us)
    with closing(DatagramSender(GroupAddress(*first.address[:2]), report)) as by:
        for _ in range(_FORWARD_COUNT):
            by.send(outer.forward(encode_forward(host, port, inner.query())))
            await asyncio.sleep(_FORWARD_PERIOD_S)
    survey = Survey(to_second, GroupAddress(host, port), report, inner)
    await survey.run(_CONFIRM_S, until_answered=True)
    for robot in survey.robots.values():
        status = robot.status
        # The status counts from the first frame that arrived, directly or through the other robot.
        return status.sequence - status.received_count - status.lost_count + 1 <= _FORWARD_COUNT
    return None
