"""`rostether doctor`: reports why a board does not connect."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.completions import complete_ports
from rostether.cli.access.graph_options import ros2_option
from rostether.cli.access.options import ADDRESS_HINTS, msg_path_option
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import NumberRange, add_flag, add_option
from rostether.cli.shell.output import json_option, paint_finding, warn, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.transports.address_parser import parse_address

if TYPE_CHECKING:
    from rostether.bridge.health.doctor import Diagnosis
    from rostether.transports.serial_port import SerialPort


@verb(
    "doctor",
    """
    rostether doctor                               the board that is plugged in
    rostether doctor /dev/ttyACM0
    rostether doctor "/dev/ttyUSB0?baud=115200" --duration 30
    rostether doctor tcp://0.0.0.0:11411           a board on the network
    rostether doctor sim:blink.ino                 a sketch on a simulated board
    rostether doctor /dev/ttyACM0 --json
    rostether doctor --fleet --key-file fleet.key  the robots of a fleet
    rostether doctor --ros2                        the ROS 2 graph and routers
    """,
    hints=ADDRESS_HINTS,
    old_options={"--seconds": "--duration"},
)
@click.argument("port", required=False, metavar="[PORT]", shell_complete=complete_ports)
@add_option(
    "--duration seconds SECONDS",
    "Watch a connected board for this many seconds (default: 8); 60 or more show restart loops and clock "
    "drift better.",
    type=NumberRange(min=1.0, max=3600.0),
)
@ros2_option(
    "Check whether the ROS 2 graph can be reached, instead of a board: routers, certificates, nodes."
)
@add_flag(
    "--fleet",
    "Examine the robots of a fleet instead of a board; --duration is then the time to listen for an "
    "IGMP querier. See also: fleet doctor.",
)
@add_option("--key-file FILE", "With --fleet, the fleet's key.")
@add_option(
    "--interface interfaces NAME", "With --fleet, the network interface; may be repeated.", multiple=True
)
@msg_path_option
@json_option
async def doctor(
    port: str | None,
    seconds: float | None,
    ros2: str | None,
    fleet: bool,
    key_file: str | None,
    interfaces: tuple[str, ...],
    msg_paths: tuple[Path, ...],
    as_json: bool,
) -> int:
    """Diagnose why a board does not connect, and show what to do next.

    PORT is a serial port or any other link address (default: the boards on USB, else those of a running
    bridge). No other program may use the port at the same time. The exit code is 0 if the board is healthy, 1
    if there is a problem.
    """
    if fleet:
        if (port, ros2) != (None, None):
            raise click.UsageError("with --fleet, doctor examines no board; omit PORT and --ros2")
        from rostether.cli.platform.fleet import examine_fleet
        from rostether.cli.platform.fleet_options import FleetOptions

        settings = FleetOptions(key_file=key_file, interfaces=interfaces).settings()
        return await examine_fleet(settings, seconds or 1.0, as_json=as_json)
    if key_file is not None or interfaces:
        raise click.UsageError("--key-file and --interface need --fleet")
    if ros2 is not None:
        if port is not None or seconds is not None:
            raise click.UsageError("with --ros2, doctor examines no board; omit PORT and --duration")
        from rostether.cli.bridge.ros2_doctor import examine_ros2

        return EXIT_DONE if await examine_ros2(ros2, as_json=as_json) else EXIT_FAILED
    return await _doctor(port, seconds, msg_paths, as_json)


async def _doctor(port: str | None, seconds: float | None, msg_paths: Sequence[Path], as_json: bool) -> int:
    from rostether.bridge.health.doctor import Doctor
    from rostether.bridge.health.watching import WATCH_S
    from rostether.bridge.reporter import SilentReporter
    from rostether.cli.access.ros1_access import type_store
    from rostether.cli.board.simulated_links import simulated
    from rostether.transports.serial import list_ports

    ports = list_ports()
    addresses = [port] if port is not None else _plugged_in(ports)
    if not addresses:
        served = await _examine_served(as_json)
        if served is None:
            _explain_no_board(ports)
        return EXIT_DONE if served else EXIT_FAILED
    examiner = Doctor(
        type_store(msg_paths),
        watch_s=WATCH_S if seconds is None else seconds,
        report_step=(lambda _: None) if as_json else warn,
        list_ports=list_ports,
    )
    is_ok = True
    links = [parse_address(address) for address in addresses]
    async with simulated(links, SilentReporter(), msg_paths) as opened:
        for link in opened:
            diagnosis = await examiner.examine(link)
            is_ok = is_ok and diagnosis.is_ok
            _write(diagnosis, as_json)
    return EXIT_DONE if is_ok else EXIT_FAILED


def _plugged_in(ports: Sequence[SerialPort]) -> list[str]:
    """Return the ports to examine by default: the only one on USB, or those of known boards."""
    from rostether.ports.usb_boards import board_of

    on_usb = [port for port in ports if port.usb_vendor_id is not None]
    if len(on_usb) == 1:
        return [on_usb[0].path]
    return [port.path for port in on_usb if board_of(port.usb_vendor_id, port.usb_product_id)]


def _explain_no_board(ports: Sequence[SerialPort]) -> None:
    on_usb = [port for port in ports if port.usb_vendor_id is not None]
    listed = ", ".join(f"{port.path} ({port.description})" for port in on_usb or ports)
    if on_usb:
        warn(f"found {listed}; choose the board's port, for example: rostether doctor {on_usb[0].path}")
    else:
        beside = f"; other ports: {listed}" if ports else ""
        warn(
            f"no board found on USB{beside}; use a USB cable that carries data (some only charge), or "
            "give the board's address, for example tcp://0.0.0.0:11411"
        )


async def _examine_served(as_json: bool) -> bool | None:
    """Report the boards of a running bridge; return whether they are healthy, None if there are none."""
    from rostether.bridge.health.reported_boards import reported_boards
    from rostether.cli.access.graph_options import GraphOptions
    from rostether.cli.access.ros1_access import joined, read_environment
    from rostether.cli.access.served_graphs import master_answers
    from rostether.cli.bridge.doctor_report import reported_lines, reported_record

    options = GraphOptions()
    environment = read_environment(options)
    if not await master_answers(environment):
        return None
    async with joined(options, purpose="doctor", environment=environment) as graph:
        boards = await reported_boards(graph)
    for board in boards:
        if as_json:
            write_json(reported_record(board))
            continue
        for line in reported_lines(board, environment.master_uri):
            write_line(line, paint_finding)
    return all(not board.level for board in boards) if boards else None


def _write(diagnosis: Diagnosis, as_json: bool) -> None:
    from rostether.cli.bridge.doctor_report import board_record, finding_record, lines_of

    if as_json:
        for finding in diagnosis.findings:
            write_json(finding_record(diagnosis, finding))
        write_json(board_record(diagnosis))
        return
    for line in lines_of(diagnosis):
        write_line(line, paint_finding)
