"""`rostether serial-node`: accepts the arguments of `serial_node.py` and prints the same lines.

    serial-node [PORT | tcp [TCP_PORT]] [_port:=... _baud:=... _tcp_port:=...] [__name:=... __ns:=...] [a:=b]

Private parameters may also be on the parameter server: ~port, ~baud, ~tcp_port. As with serial_node.py, the
node joins the graph before the board connects, and the process ends with its node.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

import click
from msgspec import Struct

from rostether.cli.access.completions import complete_ports
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import listen_option
from rostether.cli.access.ros1_access import read_environment, ros1_join, type_store
from rostether.cli.access.served_graphs import used_master
from rostether.cli.bridge.options import config_option, read_devices
from rostether.cli.bridge.serving import loopback_lines, read_links, serving
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError, GraphError, UnknownNameError
from rostether.graph.ports import Level
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.loopback import LOOPBACK
from rostether.names.graph_name import canonical, join, validate_name
from rostether.names.remap import Arguments, parse_arguments
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient
from rostether.transports.address import DEFAULT_PORT, SimAddress, TcpAddress
from rostether.transports.opening import listen as listen_for_links

# As in serial_node.py.
DEFAULT_SERIAL_PORT = "/dev/ttyUSB0"
DEFAULT_NODE_NAME = "serial_node"
# The last two are settings of the established host's implementation; they are accepted and have no effect.
PRIVATE_PARAMETERS = ("port", "baud", "tcp_port", "fork_server", "fix_pyserial_for_test")


class HostRole(Struct, frozen=True):
    """A rosserial host to replace: its node's name, its first line, its parameters, its choice of a link.

    `choose_link` returns a link address from the node's arguments, its private parameters, and the options
    that name the board's node.
    """

    node_name: str
    greeting: str
    parameters: tuple[str, ...]
    choose_link: Callable[[list[str], Mapping[str, object], str], str]


@verb(
    "serial-node",
    """
    rostether serial-node /dev/ttyACM0
    rostether serial-node _port:=/dev/ttyACM0 _baud:=115200 __name:=opencr
    rostether serial-node tcp 11411
    rostether serial-node /dev/ttyUSB0 servo_control:=servo_pose_server
    """,
    is_service=True,
    context_settings={"ignore_unknown_options": True},
)
@listen_option
@graph_options(served=True, master=False, ros=False)
@config_option
@click.argument(
    "arguments",
    nargs=-1,
    type=click.UNPROCESSED,
    shell_complete=complete_ports,
    metavar="[PORT | tcp [TCP_PORT]] [NAME:=VALUE...]",
)
async def serial_node(
    arguments: tuple[str, ...], listen: str | None, config: Path | None, graph: GraphOptions
) -> None:
    """Connect one board, with the arguments of serial_node.py.

    Settings in devices.toml apply unless an argument overrides them; __name sets the board's name.
    """
    wrong = next((each for each in arguments if each.startswith("--")), None)
    if wrong is not None:
        name = wrong.partition("=")[0].removeprefix("--")
        argument = {"master": "__master:=URI", "name": "__name:=NAME", "ns": "__ns:=NAMESPACE"}.get(name)
        if name.replace("-", "_") in PRIVATE_PARAMETERS:
            argument = f"_{name.replace('-', '_')}:=VALUE"
        step = f"write {argument}" if argument else "see `rostether serial-node --help`"
        raise click.UsageError(f"no such option {wrong}; {step}")
    host = HostRole(DEFAULT_NODE_NAME, "ROS Serial Python Node", PRIVATE_PARAMETERS, choose_link)
    await run_host(host, parse_arguments(arguments), listen=listen, allowed=graph.allow, config=config)


async def run_host(
    host: HostRole,
    arguments: Arguments,
    *,
    listen: str | None = None,
    allowed: tuple[str, ...] = (),
    config: Path | None = None,
) -> None:
    """Serve the boards on a host's link until canceled.

    `listen` and `allowed` are the values of --listen and --allow; without `config`, the user's file is read.
    Raises ConfigError, InvalidNameError, GraphError, TransportOpenError.
    """
    from rostether.bridge.settings import BoardNodes
    from rostether.bridge.supervisor import Links, Supervisor

    reporter = ConsoleReporter(show_node=False)
    for name in arguments.private_params.keys() - set(host.parameters):
        reporter.report(Level.WARN, f"unknown parameter _{name}; known: _{', _'.join(host.parameters)}")
    for name in arguments.remappings.keys() & set(host.parameters):
        reporter.report(Level.WARN, f"{name}:= remaps a topic; write _{name}:= to set the {name}")
    environment = read_environment(GraphOptions(arguments=arguments.special, allow=allowed), listen)
    devices = read_devices(config, ())
    hosts = environment.listen_hosts if listen is not None else (LOOPBACK,)
    reporter.report(Level.INFO, host.greeting)
    namespace = canonical(join("/", arguments.special.get("__ns", environment.namespace)))
    node_name = validate_name(join(namespace, arguments.special.get("__name", host.node_name)))
    async with used_master(environment, is_chosen="__master" in arguments.special) as used:
        parameters = await _server_parameters(used.environment, node_name, host.parameters)
        parameters |= arguments.private_params
        link = host.choose_link(arguments.rest, parameters, name_options(node_name, namespace))
        links = read_links(link, hosts, allowed)
        if isinstance(links[0], SimAddress):
            raise ConfigError(
                f"serial-node does not serve simulated boards; use `rostether serve {shlex.quote(link)}`"
            )
        consent = "--listen 0.0.0.0"
        if "listen" in host.parameters:
            consent = "_listen:=0.0.0.0 (with roslaunch, listen:=0.0.0.0)"
        for line in loopback_lines(used.environment, links, consent=consent):
            reporter.report(Level.INFO, line)
        if isinstance(links[0], TcpAddress):
            reporter.report(Level.INFO, f"Waiting for socket connections on port {links[0].port}")
        supervisor = Supervisor(
            ros1_join(used.environment),
            type_store(),
            reporter=reporter,
            devices=devices,
            nodes=BoardNodes(keeps_node=True, remappings=arguments.remappings, diagnostics=True),
            links=Links(listen=partial(listen_for_links, board_keys=devices.board_keys())),
        )
        async with serving(supervisor, links, reporter):
            # The process ends with its node, even if another program ended the node: respawn depends on that.
            await supervisor.wait_done()


async def _server_parameters(
    environment: RosEnvironment, node_name: str, names: Sequence[str]
) -> dict[str, object]:
    """Return the private parameters on the parameter server; none if no master answers."""
    found: dict[str, object] = {}
    async with closed_at_end(MasterClient(environment.master_uri, node_name)) as client:
        with suppress(GraphError):
            for name in names:
                with suppress(UnknownNameError):
                    found[name] = await client.get_param(f"{node_name}/{name}")
    return found


def choose_link(rest: list[str], parameters: Mapping[str, object], options: str) -> str:
    """Return the link address of serial_node.py's arguments; plain ones override private parameters.

    Raises ConfigError.
    """
    known = [argument for argument in rest if argument]
    if len(known) > 2:
        raise ConfigError(f"unexpected argument {known[2]!r}; write PORT, or tcp and its port")
    wanted = parameters.get("port", DEFAULT_SERIAL_PORT)
    if not known and not isinstance(wanted, str | int):
        # As in ROS, a value is read as YAML: `tcp:` is a mapping.
        raise ConfigError("port must be a serial port or tcp; write _port:=tcp or a path")
    target = known[0] if known else str(wanted)
    if target == "tcp":
        port = read_whole_number(
            known[1] if len(known) == 2 else parameters.get("tcp_port", DEFAULT_PORT), "tcp_port"
        )
        return f"tcp://:{port}?{options}"
    path, _, given = target.partition("?")
    baud = known[1] if len(known) == 2 else parameters.get("baud")
    if baud is not None:
        number = read_whole_number(baud, "baud")
        given = given or f"baud={number}"
    # Without a baud rate here, that of devices.toml applies.
    return f"{path}?{options}" + (f"&{given}" if given else "")


def name_options(node_name: str, namespace: str) -> str:
    """Return the options of a link address for a board whose node has this full name."""
    name = node_name.removeprefix(namespace.rstrip("/") + "/")
    return f"name={name}" + (f"&ns={namespace}" if namespace != "/" else "")


def read_whole_number(value: object, name: str) -> int:
    """Return a whole-number parameter. Raises ConfigError."""
    text = str(value).strip()
    if isinstance(value, bool) or not text.isdecimal():
        raise ConfigError(f"{name} must be a whole number, not {text!r}")
    return int(text)
