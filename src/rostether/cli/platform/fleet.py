"""`rostether fleet`: robots that obey framed commands, without a ROS graph."""

from __future__ import annotations

import shutil
import struct
from contextlib import closing
from dataclasses import dataclass

import click
from msgspec.structs import replace

from rostether.cli.platform.fleet_options import MAX_ROBOT, FleetOptions, fleet_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import (
    POSITIVE,
    NumberRange,
    add_option,
    flag,
    option,
    option_group,
    shared,
)
from rostether.cli.shell.output import json_option, warn, write_finding, write_json, write_line, write_table
from rostether.cli.shell.verbs import verb, verb_group
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.platform.command_frame import type_kind
from rostether.platform.fleet import FleetSender, FleetSettings, has_stopped, silence_text
from rostether.platform.fleet_examination import examine
from rostether.platform.fleet_findings import disk_finding, fleet_findings
from rostether.platform.robot_table import Robot

_CONTROL = "arduino_control/ArduinoControl"
_robot = click.argument("robot", type=click.IntRange(1, MAX_ROBOT), required=False, metavar="[ROBOT]")


fleet = verb_group(
    "fleet",
    """Command robots by id and group, over UDP multicast.

    The robots run `rostether role multicast-topic-receiver` with `_framed:=true`. All have the same key.
    """,
    {
        "list": ("fleet:list_robots", "List the robots that answer."),
        "status": ("fleet:status", "Show loss, signal and sender of robots."),
        "doctor": ("fleet:doctor", "Find out why robots do not obey."),
        "drive": ("fleet:drive", "Drive robots in a direction."),
        "stop": ("fleet:stop", "Stop robots, even those of other senders."),
    },
    """
    rostether fleet list --key-file fleet.key
    rostether fleet drive 3 --speed 0.5 --for 2 --key-file fleet.key
    rostether fleet stop --key-file fleet.key
    """,
    package="rostether.cli.platform",
)


@verb("list", "rostether fleet list --interface wlan0 --key-file fleet.key")
@json_option
@fleet_options
async def list_robots(as_json: bool, fleet: FleetOptions) -> int:
    """List the robots that answer: id, address, whether they move, and which sender commands them."""
    return await _query(fleet.settings(), as_json, detailed=False)


@verb("status", "rostether fleet status 3 --key-file fleet.key")
@_robot
@json_option
@fleet_options
async def status(robot: int | None, as_json: bool, fleet: FleetOptions) -> int:
    """Show the loss of multicast, the Wi-Fi signal and the sender of one robot, or of all."""
    return await _query(fleet.settings(robot), as_json, detailed=True)


@dataclass(frozen=True, slots=True)
class DriveOptions:
    """The argument and the options of `fleet drive`."""

    robot: int | None = shared(_robot, None)
    to_all: bool = flag("--all", "Drive the robots of all groups.")
    speed: float = option(
        "--speed",
        "The speed, from 0 to 1 (full speed).",
        type=NumberRange(0, 1),
        default=0.3,
        show_default=True,
    )
    direction_deg: float = option(
        "--direction",
        "The direction in degrees: 0 is forward, 90 right, 180 back.",
        type=NumberRange(-180, 180),
        default=0.0,
        show_default=True,
    )
    duration_s: float | None = option(
        "--for SECONDS", "Stop after this time (default: at Ctrl-C).", type=POSITIVE
    )


@verb(
    "drive",
    """
    rostether fleet drive 3 --speed 0.5 --for 2 --key-file fleet.key
    rostether fleet drive --groups 0 --direction 90 --key-file fleet.key
    """,
)
@option_group("options", DriveOptions)
@fleet_options
async def drive(options: DriveOptions, fleet: FleetOptions) -> int:
    """Drive one robot or groups (arduino_control/ArduinoControl) for the time of --for, or until Ctrl-C.

    One sender commands a robot at a time. A robot stops automatically 0.3 s after the last command. The exit
    code is 1 if no robot answers.
    """
    targets = (options.robot is not None, fleet.groups is not None, options.to_all)
    if sum(targets) != 1:
        raise click.UsageError("give one of ROBOT, --groups or --all")
    settings = fleet.settings(options.robot)
    kind = type_kind(Registry().message_type(_CONTROL).md5sum)
    settings = replace(settings, sender=replace(settings.sender, kind=kind))
    payload = struct.pack("<dd", options.direction_deg, options.speed)
    with closing(FleetSender(settings, _report)) as sender:
        await sender.drive(payload, options.duration_s or float("inf"))
    return EXIT_DONE if sender.robots else EXIT_FAILED


@verb("stop", "rostether fleet stop 3 --key-file fleet.key")
@_robot
@json_option
@fleet_options
async def stop(robot: int | None, as_json: bool, fleet: FleetOptions) -> int:
    """Stop one robot or all, even if another sender commands them; list those that confirm the stop.

    The sender that commanded them must start again. The exit code is 1 if no robot confirms the stop, or if
    a robot answers without confirming it.
    """
    settings = fleet.settings(robot)
    with closing(FleetSender(settings, _report)) as sender:
        robots = await sender.stop()
    for each in robots:
        number, address, is_stopped = each.status.robot_id, each.address[0], has_stopped(each)
        if as_json:
            write_json({"robot": number, "address": address, "stopped": is_stopped})
        elif is_stopped:
            write_line(f"robot {number} at {address} has stopped")
        else:
            warn(f"robot {number} at {address} has NOT confirmed the stop")
    if not robots:
        warn(silence_text(settings))
    return EXIT_DONE if robots and all(map(has_stopped, robots)) else EXIT_FAILED


@verb(
    "doctor",
    """
    rostether fleet doctor --interface wlan0 --key-file fleet.key
    sudo "$(which rostether)" fleet doctor --duration 130   also listens for the IGMP querier
    """,
)
@add_option(
    "--duration listen_s SECONDS",
    "Listen for an IGMP querier for this time (default: while the robots are asked).",
    type=NumberRange(min=1.0, max=3600.0),
    default=1.0,
)
@json_option
@fleet_options
async def doctor(listen_s: float, as_json: bool, fleet: FleetOptions) -> int:
    """Find out why robots do not obey: networks, ids, clocks and disks.

    It measures the loss and the signal of each robot, and compares multicast with unicast. It finds robots
    that do not reach each other, ids that two robots have, clocks that differ, full disks, and (with root)
    networks without an IGMP querier. It commands no robot. The exit code is 1 if there is a problem.
    """
    return await examine_fleet(fleet.settings(), listen_s, as_json=as_json)


async def examine_fleet(settings: FleetSettings, listen_s: float, *, as_json: bool) -> int:
    """Print the findings, after listening for an IGMP querier for `listen_s`; return the exit code.

    Raises ConfigError.
    """
    found = await examine(settings, _report, listen_s)
    findings = fleet_findings(found, silence_text(settings))
    disk = shutil.disk_usage(".")
    findings.append(disk_finding("this folder", disk.free, disk.total))
    for finding in findings:
        write_finding(finding.what, finding.text, is_ok=finding.is_ok, as_json=as_json)
    return EXIT_FAILED if any(each.is_ok is False for each in findings) else EXIT_DONE


async def _query(settings: FleetSettings, as_json: bool, *, detailed: bool) -> int:
    with closing(FleetSender(settings, _report)) as sender:
        await sender.query()
    if as_json:
        for robot in sender.robots:
            write_json(_record(robot))
    elif sender.robots:
        head = ["robot", "address", "state", "commanded by", *(["loss", "signal"] if detailed else [])]
        write_table([head, *(_cells(each, detailed) for each in sender.robots)])
    if not sender.robots:
        warn(silence_text(settings))
    return EXIT_DONE if sender.robots else EXIT_FAILED


def _report(_: Level, text: str) -> None:
    warn(text)


def _record(robot: Robot) -> dict[str, object]:
    status = robot.status
    return {
        "robot": status.robot_id,
        "address": robot.address[0],
        "moving": status.is_moving,
        "commanded_by": status.holder,
        "received": status.received_count,
        "lost": status.lost_count,
        "loss": robot.loss,
        "signal_dbm": status.signal_dbm,
    }


def _cells(robot: Robot, detailed: bool) -> list[str]:
    status = robot.status
    cells = [
        str(status.robot_id),
        robot.address[0],
        "moving" if status.is_moving else "stopped",
        status.holder or "-",
    ]
    if detailed:
        cells.append("-" if robot.loss is None else f"{robot.loss:.0%}")
        cells.append("-" if status.signal_dbm is None else f"{status.signal_dbm} dBm")
    return cells
