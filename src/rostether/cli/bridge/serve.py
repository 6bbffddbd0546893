"""`rostether serve`: boards become nodes."""

from __future__ import annotations

import gc
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.options import allow_option, listen_option, msg_path_option
from rostether.cli.access.ros1_access import read_environment
from rostether.cli.access.ros2_options import Ros2Options, read_ros2_options, ros2_options
from rostether.cli.access.ros_choice import Middleware, chosen_ros1, chosen_ros2
from rostether.cli.bag.record_options import (
    BagRecording,
    bag_recording_options,
    bags_recorded,
    read_bag_recording,
)
from rostether.cli.bag.recording import record_limit_option, recorded
from rostether.cli.board.simulated_links import simulated
from rostether.cli.bridge.announcing import announced, check_mdns
from rostether.cli.bridge.device_options import (
    config_option,
    discover_option,
    probe_option,
    read_devices,
    unchosen_lines,
)
from rostether.cli.bridge.limit_options import BRIDGE_LIMITS, GRAPH_LIMITS, limit_option, read_limits
from rostether.cli.bridge.lines import ConsoleReporter
from rostether.cli.bridge.served_graphs import served_graphs
from rostether.cli.bridge.serving import bridge, loopback_lines, read_links
from rostether.cli.gateway.gateways import served_gateways
from rostether.cli.gateway.options import GatewayOptions, gateway_options, read_gateway_options
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.devices.config_paths import known_boards_path
from rostether.devices.device_book import DeviceBook
from rostether.devices.known_boards import KnownBoards
from rostether.errors import ConfigError
from rostether.graph.ports import Level
from rostether.ros1.environment import LOOPBACK, RosEnvironment
from rostether.transports.address import Address
from rostether.transports.opening import listen as listen_for_links

if TYPE_CHECKING:
    from rostether.bridge.settings import BridgeSettings
    from rostether.transports.board_keys import BoardKeys


@click.command(
    cls=Verb,
    examples="""
    rostether serve                                   boards on USB, as they are plugged in
    rostether serve /dev/ttyACM0                      this port, at 57600 baud
    rostether serve "/dev/ttyUSB0?baud=115200&name=arm"
    rostether serve tcp://:11411 udp://:11411         boards on this machine
    rostether serve tcp://0.0.0.0:11411               boards on the network
    rostether serve pty:/tmp/board                    for a simulator
    rostether serve "sim:blink.ino?board=uno"         a simulated board of ours
    rostether serve /dev/ttyACM0 /dev/ttyACM1 --ns-per-board
    rostether serve /dev/ttyACM0 --rosbridge          web pages with roslibjs, too
    rostether serve /dev/ttyACM0 --foxglove           and Foxglove
    rostether serve /dev/ttyACM0 --ros2 zenoh         a ROS 2 node
    rostether serve /dev/ttyACM0 --ros1 --ros2 rclpy  in both graphs
    rostether serve /dev/ttyACM0 --record bags        all topics into bags, too
    """,
)
@click.argument("addresses", nargs=-1, metavar="[ADDRESS...]")
@click.option("--master", metavar="URI", help="The ROS master to join; it is waited for.")
@click.option(
    "--master-port",
    type=click.IntRange(1, 65535),
    metavar="PORT",
    help="The port where we are the master when there is none (11311).",
)
@ros2_options
@listen_option
@allow_option
@msg_path_option
@config_option
@discover_option
@probe_option
@click.option(
    "--mdns/--no-mdns",
    default=None,
    help="Announce TCP listeners that the network can reach (when zeroconf is installed).",
)
@click.option("--ns-per-board", is_flag=True, help="Put each board's topics into a namespace of its name.")
@click.option("--no-diagnostics", is_flag=True, help="Do not publish /diagnostics from the boards' nodes.")
@gateway_options
@bag_recording_options
@click.option(
    "--record-line",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Record what goes over the lines to a new file; see `rostether link`.",
)
@record_limit_option
@limit_option({**BRIDGE_LIMITS, **GRAPH_LIMITS})
@click.option("-v", "--verbose", is_flag=True, help="Show the boards' debug lines too.")
@click.option("--uvloop", is_flag=True, help="Run on uvloop: pip install 'rostether[uvloop]'.")
def serve(
    addresses: tuple[str, ...],
    master: str | None,
    master_port: int | None,
    listen: str | None,
    allowed: tuple[str, ...],
    msg_paths: tuple[Path, ...],
    config: Path | None,
    discover: bool,
    probes: tuple[str, ...],
    mdns: bool | None,
    ns_per_board: bool,
    no_diagnostics: bool,
    record_line: Path | None,
    record_limit_mb: float,
    limits: tuple[str, ...],
    verbose: bool,
    uvloop: bool,
) -> None:
    """Make boards that speak rosserial nodes of the ROS graph.

    Without an ADDRESS, boards on USB are found, at any usual baud rate, and served as they come and go; other
    devices are left alone.

    An ADDRESS is a serial port, tcp://HOST:PORT or udp://HOST:PORT to listen on, pty:PATH for a
    pseudo-terminal made there, xbee:PORT, sim:SKETCH for a simulated board that runs it. Options go behind a
    question mark: baud=115200, name=arm, ns=lab, reset=no. A port that does not exist yet is waited for.
    """
    twice = next((address for address in addresses if addresses.count(address) > 1), None)
    if twice is not None:
        raise click.UsageError(f"{twice} is given twice; one address serves one port")
    if master is not None and master_port is not None:
        raise ConfigError("--master joins a master and --master-port is one: give one of them")
    environment = read_environment(master)
    if listen is not None:
        environment = environment.listening_on(listen)
    settings, graph_limits = read_limits(limits)
    environment = environment.allowing(allowed).limited(graph_limits)
    hosts = environment.listen_hosts if listen is not None else (LOOPBACK,)
    links = [link for address in addresses for link in read_links(address, hosts, allowed)]
    devices = read_devices(config, probes)
    discovers = discover or bool(probes) or not addresses
    announces = check_mdns(is_wanted=mdns)
    reporter = ConsoleReporter(lowest=Level.DEBUG if verbose else Level.INFO)
    run(
        _serve(
            environment,
            links,
            reporter,
            master is not None,
            master_port,
            msg_paths,
            ns_per_board,
            not no_diagnostics,
            devices,
            discovers=discovers,
            announces=announces,
            wants_mdns=mdns is True,
            gateways=read_gateway_options(allowed),
            bags=read_bag_recording(),
            record_line=record_line,
            record_limit_mb=record_limit_mb,
            settings=settings,
            board_keys=devices.board_keys(),
            ros1=chosen_ros1(),
            ros2=chosen_ros2(),
            options=read_ros2_options(),
        ),
        is_service=True,
        uvloop=uvloop,
    )


async def _serve(
    environment: RosEnvironment,
    links: Sequence[Address],
    reporter: ConsoleReporter,
    is_chosen: bool,
    master_port: int | None,
    msg_paths: Sequence[Path],
    ns_per_board: bool,
    diagnostics: bool,
    devices: DeviceBook,
    *,
    discovers: bool,
    announces: bool,
    wants_mdns: bool,
    gateways: GatewayOptions,
    bags: BagRecording | None,
    record_line: Path | None,
    record_limit_mb: float,
    settings: BridgeSettings,
    board_keys: BoardKeys,
    ros1: bool,
    ros2: Middleware | None,
    options: Ros2Options,
) -> None:
    listen_bounded = partial(
        listen_for_links,
        connections=settings.connections,
        connections_per_host=settings.connections_per_host,
        board_keys=board_keys,
    )
    async with served_graphs(
        environment,
        ros1=ros1,
        ros2=ros2,
        options=options,
        is_chosen=is_chosen,
        master_port=master_port,
        msg_paths=msg_paths,
    ) as graphs:
        for line in (*graphs.lines, *loopback_lines(graphs.ros1, links)):
            reporter.line(Level.INFO, line)
        for line in unchosen_lines(devices, links):
            reporter.line(Level.WARN, line)
        async with (
            recorded(record_line, record_limit_mb, reporter) as tap,
            bags_recorded(bags, graphs.join, reporter, types=None if ros1 else graphs.types),
            simulated(links, reporter, msg_paths) as opened,
            bridge(
                graphs.join,
                opened,
                reporter,
                msg_paths=msg_paths,
                ns_per_board=ns_per_board,
                devices=devices,
                diagnostics=diagnostics,
                tap=tap,
                listen=listen_bounded,
                settings=settings,
            ) as supervisor,
            announced(supervisor.listening_on, reporter, is_on=announces, is_wanted=wants_mdns),
            # Last: a master that is away holds up no board.
            served_gateways(gateways, graphs, ros2, options, msg_paths, reporter.line),
        ):
            if discovers:
                supervisor.discover(KnownBoards(known_boards_path()), taken=opened)
            # What is there now stays; looking through it for garbage at times holds up messages for 20 ms.
            gc.freeze()
            await supervisor.wait_done()
