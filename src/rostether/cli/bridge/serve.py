"""`rostether serve`: connects boards to the graph as nodes."""

from __future__ import annotations

import gc
from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource
from msgspec import Struct
from msgspec.structs import replace

from rostether.cli.access.completions import complete_ports
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import ADDRESS_HINTS, listen_option, msg_path_option
from rostether.cli.access.ros1_access import read_environment, type_store
from rostether.cli.access.served_graphs import check_master, served_graphs
from rostether.cli.bag.bridge_recording import (
    BagRecording,
    bags_recorded,
    record_limit_option,
    recorded,
)
from rostether.cli.bridge.announcing import announced, check_mdns
from rostether.cli.bridge.options import (
    BRIDGE_LIMITS,
    GRAPH_LIMITS,
    config_option,
    discover_option,
    limit_option,
    probe_option,
    read_devices,
    read_limits,
    unchosen_lines,
)
from rostether.cli.bridge.serving import (
    check_addresses,
    loopback_lines,
    read_links,
    read_web_boards,
    serving,
    shortage_lines,
)
from rostether.cli.dashboard.optional import optional_dashboard, optional_gateways
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.cli.gateway.options import GatewayOptions, dashboard_option, gateway_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.library_logs import show_debug_records
from rostether.cli.shell.option_group import FILE, PORT, flag, option, option_group, shared
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.graph.ports import JoinGraph, Level
from rostether.mechanisms.loopback import LOOPBACK
from rostether.ports.config_paths import known_boards_path
from rostether.ports.device_book import DeviceBook
from rostether.ports.known_boards import KnownBoards
from rostether.ros1.environment import RosEnvironment
from rostether.transports.address import Address, SimAddress
from rostether.transports.opening import listen as listen_for_links

if TYPE_CHECKING:
    from rostether.bridge.reporter import Reporter
    from rostether.bridge.settings import BridgeSettings


@dataclass(frozen=True, slots=True)
class ServeOptions:
    """The options of `serve` about the boards and their lines."""

    master_port: int | None = option(
        "--master-port PORT",
        "Port for the ROS master, which is started if none runs (default: that of ROS_MASTER_URI, or 11311).",
        type=PORT,
    )
    listen: str | None = shared(listen_option, None)
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())
    config: Path | None = shared(config_option, None)
    discover: bool = shared(discover_option, False)
    probes: tuple[str, ...] = shared(probe_option, ())
    mdns: bool | None = option(
        "--mdns/--no-mdns",
        "Announce TCP listeners that other machines can reach (default: if zeroconf is installed).",
    )
    ns_per_board: bool = flag(
        "--ns-per-board", "Put each board's topics into a namespace with the board's name."
    )
    no_diagnostics: bool = flag("--no-diagnostics", "Do not publish /diagnostics.")
    no_web_boards: bool = flag(
        "--no-web-boards", "Refuse boards on the serial ports of devices that show the dashboard."
    )
    record_line: Path | None = option(
        "--record-line FILE",
        "Record the bytes on the boards' lines to a new file; see `rostether link`.",
        type=FILE,
    )
    record_limit_mb: float = shared(record_limit_option, 100)
    limits: tuple[str, ...] = shared(limit_option({**BRIDGE_LIMITS, **GRAPH_LIMITS}), ())
    verbose: int = option(
        "-v --verbose",
        "Also show debug messages from boards; -vv: also each change of their state.",
        count=True,
        default=0,
    )
    uvloop: bool = flag("--uvloop", "Use uvloop (install with: pip install 'rostether[uvloop]').")


@verb(
    "serve",
    """
    rostether serve                             boards on USB, as you plug them in
    rostether serve /dev/ttyACM0                this port, at 57600 baud
    rostether serve "/dev/ttyUSB0?baud=115200&name=arm"
    rostether serve tcp://:11411 udp://:11411   boards on this machine
    rostether serve tcp://0.0.0.0:11411         boards on the network
    rostether serve pty:/tmp/board              for a simulator
    rostether serve "sim:blink.ino?board=uno"   a simulated board
    rostether serve /dev/ttyACM0 /dev/ttyACM1 --ns-per-board
    rostether serve /dev/ttyACM0 --dashboard    a page for browsers, too
    rostether serve /dev/ttyACM0 --rosbridge    web pages with roslibjs, too
    rostether serve /dev/ttyACM0 --foxglove     and Foxglove
    rostether serve /dev/ttyACM0 --ros2 zenoh   a ROS 2 node
    rostether serve /dev/ttyACM0 --ros1 --ros2 rclpy
    rostether serve /dev/ttyACM0 --record bags  all topics into bags, too
    """,
    hints=ADDRESS_HINTS
    | {
        "--name": 'write it after the address: "/dev/ttyACM0?name=arm"',
        "--ns": 'write it after the address: "/dev/ttyACM0?ns=lab"; or give --ns-per-board',
        "--port": "write the port without an option: /dev/ttyACM0",
        "-p": "write the port without an option: /dev/ttyACM0",
        "--board": 'for a simulated board, write "sim:blink.ino?board=uno"',
    },
)
@option_group("options", ServeOptions)
@click.argument(
    "addresses", nargs=-1, metavar="[ADDRESS...]", shell_complete=complete_ports, callback=check_addresses
)
@graph_options(served=True)
@dashboard_option
@gateway_options
@option_group("bags", BagRecording, heading="Recording")
def serve(
    options: ServeOptions,
    addresses: tuple[str, ...],
    graph: GraphOptions,
    dashboard: str | None,
    gateways: GatewayOptions,
    bags: BagRecording,
) -> int:
    """Connect boards with rosserial firmware to the ROS graph as nodes.

    Without an ADDRESS, boards on USB are detected at any usual baud rate and served when plugged in; other
    devices are left alone.

    An ADDRESS is a serial port, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT to listen on, pty:PATH
    for a new pseudo-terminal, xbee:PORT, sim:SKETCH for a simulated board, or web: for boards that are
    plugged into a device that shows the dashboard (--dashboard adds it). Options follow a question mark:
    baud=115200, name=arm, ns=lab, reset=no. If a port does not exist yet, the bridge waits for it.
    """
    twice = next((address for address in addresses if addresses.count(address) > 1), None)
    if twice is not None:
        raise click.UsageError(f"{twice} is given twice; give each address once")
    bags.create_folder()
    check_master(graph, options.master_port)
    environment = read_environment(graph, options.listen)
    settings, graph_limits = read_limits(options.limits)
    environment = environment.limited(graph_limits)
    hosts = environment.listen_hosts if options.listen is not None else (LOOPBACK,)
    links = [link for address in addresses for link in read_links(address, hosts, graph.allow)]
    web_boards = read_web_boards(links, is_served=dashboard is not None, is_refused=options.no_web_boards)
    devices = read_devices(options.config, options.probes)
    discovers = options.discover or bool(options.probes) or not addresses
    check_mdns(is_wanted=options.mdns)
    if options.verbose > 1:
        show_debug_records()
    reporter = ConsoleReporter(lowest=Level.DEBUG if options.verbose else Level.INFO)
    access = replace(gateways, allow=graph.allow)
    if (dashboard, gateways.foxglove, gateways.rosbridge) == (None, None, None):
        _refuse_token()
    dashboard_settings = (
        DashboardSettings(dashboard, access, boards=web_boards) if dashboard is not None else None
    )
    serving_settings = _Settings(links, devices, discovers, access, dashboard_settings, bags, settings)
    return run(
        _serve(environment, graph, options, serving_settings, reporter),
        is_service=True,
        uvloop=options.uvloop,
    )


def _refuse_token() -> None:
    """Raise UsageError for a token that protects nothing: boards do not send it."""
    if click.get_current_context().get_parameter_source("token") is ParameterSource.COMMANDLINE:
        raise click.UsageError("--token is for web clients; add --dashboard, --foxglove or --rosbridge")


class _Settings(Struct, frozen=True):
    """The meaning of the options: the links to serve, their settings, and the limits."""

    links: Sequence[Address]
    devices: DeviceBook
    discovers: bool
    gateways: GatewayOptions
    dashboard: DashboardSettings | None
    bags: BagRecording
    limits: BridgeSettings


async def _serve(
    environment: RosEnvironment,
    graph: GraphOptions,
    options: ServeOptions,
    settings: _Settings,
    reporter: ConsoleReporter,
) -> int:
    from rostether.bridge.settings import BoardNodes
    from rostether.bridge.supervisor import Links, Supervisor

    links, msg_paths = settings.links, options.msg_paths
    listen_bounded = partial(
        listen_for_links,
        connections=settings.limits.connections,
        connections_per_host=settings.limits.connections_per_host,
        board_keys=settings.devices.board_keys(),
        web_boards=settings.dashboard.boards if settings.dashboard is not None else None,
    )
    async with served_graphs(
        environment, graph, master_port=options.master_port, msg_paths=msg_paths
    ) as graphs:
        for line in (*graphs.lines, *loopback_lines(graphs.ros1, links)):
            reporter.report(Level.INFO, line)
        for line in (
            *unchosen_lines(settings.devices, links),
            *shortage_lines(settings.limits.connections, links),
        ):
            reporter.report(Level.WARN, line)
        async with (
            recorded(options.record_line, options.record_limit_mb, reporter) as tap,
            bags_recorded(
                settings.bags, graphs.join, reporter, types=None if graph.uses_ros1 else graphs.types
            ),
            _simulated(links, reporter, msg_paths, graphs.join) as opened,
        ):
            supervisor = Supervisor(
                graphs.join,
                type_store(msg_paths),
                reporter=reporter,
                devices=settings.devices,
                settings=settings.limits,
                nodes=BoardNodes(ns_per_board=options.ns_per_board, diagnostics=not options.no_diagnostics),
                links=Links(listen=listen_bounded, tap=tap),
            )
            async with (
                serving(supervisor, opened, reporter),
                announced(supervisor.listening_on, reporter, is_wanted=options.mdns),
                # Started last, so that an unreachable master does not delay the boards.
                optional_gateways(settings.gateways, graphs, graph, msg_paths, reporter.report),
                optional_dashboard(settings.dashboard, graphs, msg_paths, reporter.report),
            ):
                if settings.discovers:
                    supervisor.discover(KnownBoards(known_boards_path()), excluded=opened)
                # Existing objects are permanent. A garbage collection that searched them would take 20 ms.
                gc.freeze()
                await supervisor.wait_done()
                return EXIT_FAILED if supervisor.has_failed else EXIT_DONE


def _simulated(
    links: Sequence[Address], reporter: Reporter, msg_paths: Sequence[Path], join: JoinGraph
) -> AbstractAsyncContextManager[list[Address]]:
    if not any(isinstance(each, SimAddress) for each in links):
        return nullcontext(list(links))
    # Importing the simulators takes a tenth of the time to the first message.
    from rostether.cli.board.simulated_links import simulated

    return simulated(links, reporter, msg_paths, join)
