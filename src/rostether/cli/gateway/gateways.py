"""How the gateways for web pages and viewers join a graph: their names, parameters and reports."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import click
from msgspec import Struct, field

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import master_client, read_environment, ros1_join, type_store
from rostether.cli.access.served_graphs import ServedGraphs, native_session, served_graphs
from rostether.cli.gateway.options import DEFAULT_ADDRESS
from rostether.cli.role.node import node_environment
from rostether.cli.shell.running import run
from rostether.errors import ConfigError, GraphError, UnknownNameError
from rostether.graph.ports import Graph, JoinGraph, Level
from rostether.mechanisms.loopback import is_loopback
from rostether.mechanisms.waiting import wait_for_master
from rostether.names.graph_name import canonical, join, validate_name
from rostether.names.remap import Arguments, parse_arguments
from rostether.ros1.environment import RosEnvironment, parse_rpc_uri
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node_queries import ping
from rostether.ros1.node.service_probe import look_up, probe_type

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.serde.store import TypeStore

# Takes a node's full name and returns whether a node of that name answers. Raises GraphError.
IsLive: TypeAlias = Callable[[str], Awaitable[bool]]

_TRUE = ("true", "1", "yes", "on")
# The values in launch files for an unset parameter; Python nodes use "None".
_NOTHING = (None, "", "None")


class NodeNaming(Struct, frozen=True):
    """The name, namespace and remappings of a gateway's node; an empty name means the gateway's own."""

    name: str = ""
    namespace: str = "/"
    remappings: Mapping[str, str] = field(default_factory=dict)

    def name_for(self, own_name: str, port: int, default_port: int) -> str:
        """Return the name. It contains the port, unless this is the default port."""
        if self.name:
            return self.name
        # Port 0 is any free port, which is not known yet.
        return own_name if port in (0, default_port) else f"{own_name}_{port}"


def read_gateway_arguments(words: Sequence[str], special: Mapping[str, str]) -> tuple[str, NodeNaming]:
    """Return the address to listen on, [HOST:]PORT, and the naming of the node.

    Raises click.UsageError, ConfigError, InvalidNameError.
    """
    arguments = parse_arguments(words)
    if arguments.private_params:
        name = next(iter(arguments.private_params))
        raise click.UsageError(
            f"_{name}:= works only for the node in launch files; use the options and HOST:PORT here"
        )
    if len(arguments.rest) > 1:
        raise click.UsageError(f"give only one [HOST:]PORT, not {' and '.join(arguments.rest)}")
    name = special.get("__name", "")
    namespace = canonical("/" + special.get("__ns", ""))
    if name:
        validate_name(name)
    validate_name(namespace)
    address = arguments.rest[0] if arguments.rest else DEFAULT_ADDRESS
    return address, NodeNaming(name, namespace, arguments.remappings)


def ros1_liveness(environment: RosEnvironment) -> IsLive:
    """Return a function that checks whether a ROS 1 node is alive: the master also lists killed nodes."""

    async def is_live(name: str) -> bool:
        master = MasterClient(environment.master_uri, name)
        try:
            uri = await master.lookup_node(name)
        except UnknownNameError:
            return False
        finally:
            await master.close()
        try:
            await ping(name, uri)
        except GraphError:
            return False
        return True

    return is_live


async def check_free(name: str, namespace: str, is_live: IsLive | None) -> None:
    """Raise GraphError if a live node has the name: a second node would end it."""
    full_name = join(namespace, name)
    if is_live is not None and await is_live(full_name):
        raise GraphError(
            f"a node {full_name} is already running; stop it, or give this one another port or name "
            "(__name:=other)"
        )


async def private_parameters(graph: TypedGraph) -> dict[str, Any]:
    """Return all private parameters of the node; empty if it has none."""
    found = await graph.get_param("~", {})
    return dict(found) if isinstance(found, Mapping) else {}


def is_true(parameters: Mapping[str, Any], name: str) -> bool:
    """Return a parameter that is true or false, False if it is missing."""
    return str(parameters.get(name, False)).strip().lower() in _TRUE


def whole_number(parameters: Mapping[str, Any], name: str, default: int) -> int:
    """Return a number that is not negative. Raises ConfigError naming the parameter."""
    value = parameters.get(name)
    if value in _NOTHING:
        return default
    try:
        number = int(str(value).strip())
    except ValueError:
        number = -1
    if isinstance(value, bool) or number < 0:
        raise ConfigError(f"~{name} must be a whole number, not {value!r}")
    return number


def certificate_files(parameters: Mapping[str, Any], switch: str) -> tuple[str, str]:
    """Return ~certfile and ~keyfile. Raises ConfigError naming the switch that needs them."""
    if not parameters.get("certfile"):
        raise ConfigError(f"~{switch} needs ~certfile and ~keyfile: a certificate and its key")
    return str(parameters["certfile"]), str(parameters.get("keyfile") or "")


Report: TypeAlias = Callable[[Level, str], None]

# Takes a service's name. Raises GraphError.
AskService: TypeAlias = Callable[[str], Awaitable[str]]


class GatewayGraph(Struct, frozen=True):
    """How gateways join a graph: their node factory, their types, and how they query services.

    With `is_ros2`, type names are those of ROS 2. ROS 1 needs `ask_service_type`, `ask_service_host` and
    `is_live`: there, a node that joins ends a running node with the same name.
    """

    join: JoinGraph
    store: TypeStore
    is_ros2: bool = False
    ask_service_type: AskService | None = None
    ask_service_host: AskService | None = None
    is_live: IsLive | None = None
    # Searched for packages before the folders of the environment.
    msg_paths: Sequence[Path] = ()


@asynccontextmanager
async def open_gateway_graph(
    graphs: ServedGraphs, options: GraphOptions, msg_paths: Sequence[Path] = ()
) -> AsyncIterator[GatewayGraph]:
    """Yield how gateways join the graphs of the boards.

    On ROS 1, or both, messages have ROS 1 types, as boards send them; on ROS 2 alone, ROS 2 types. Raises
    ConfigError, GraphError.
    """
    if graphs.ros1 is not None:
        yield ros1_gateway_graph(graphs.join, type_store(msg_paths), graphs.ros1)
        return
    from rostether.ros2.types.native_types import NativeClasses
    from rostether.serde.store import TypeStore

    async with native_session(options, msg_paths) as session:
        registry = session.types.registry
        yield GatewayGraph(session.join, TypeStore(registry, NativeClasses(registry)), is_ros2=True)


def ros1_gateway_graph(join: JoinGraph, store: TypeStore, environment: RosEnvironment) -> GatewayGraph:
    """Return how gateways join a ROS 1 graph, alone or in addition to another."""

    async def ask_type(service: str) -> str:
        async with master_client(environment) as client:
            return await probe_type(client, service)

    async def ask_host(service: str) -> str:
        async with master_client(environment) as client:
            return parse_rpc_uri(await look_up(client, service), scheme="rosrpc").host

    return GatewayGraph(
        join, store, ask_service_type=ask_type, ask_service_host=ask_host, is_live=ros1_liveness(environment)
    )


def role_gateway_graph(arguments: Arguments, store: TypeStore) -> GatewayGraph:
    """Return how a gateway that runs as a role joins the graph of its environment. Raises ConfigError."""
    environment = node_environment(arguments)
    return ros1_gateway_graph(ros1_join(environment), store, environment)


async def joined_as(gateway_graph: GatewayGraph, naming: NodeNaming, name: str, report: Report) -> Graph:
    """Join as soon as there is a master. Raises GraphError if another node has the name."""

    async def join() -> Graph:
        await check_free(name, naming.namespace, gateway_graph.is_live)
        return await gateway_graph.join(name, namespace=naming.namespace, remappings=naming.remappings)

    return await wait_for_master(join, lambda error: report(Level.WARN, f"{name} waits: {error}"))


def report_reach(gateway: str, host: str, port: int, token: str, remote_option: str, report: Report) -> None:
    """Report who can reach a gateway.

    `remote_option` is the option or command that admits other machines; `{port}` in it becomes the port.
    """
    if is_loopback(host):
        report(
            Level.INFO,
            f"{gateway}: accepts connections from this machine only; {remote_option.format(port=port)} "
            "allows other machines",
        )
    elif not token:
        report(
            Level.WARN,
            f"{gateway}: every client that reaches it can publish and call services; --token and --allow "
            "restrict that",
        )


class Gateway(Protocol):
    """A running gateway."""

    async def wait_ended(self) -> None:
        """Wait until its node has left the graph."""


def serve_gateway(
    graph: GraphOptions,
    msg_paths: Sequence[Path],
    open_gateway: Callable[[ServedGraphs, Report], AbstractAsyncContextManager[Gateway]],
) -> None:
    """Run a gateway on the graphs that the command line selects.

    Raises the same errors as `served_graphs`.
    """
    environment = read_environment(graph)

    async def serve() -> None:
        report = ConsoleReporter().report
        async with served_graphs(environment, graph, msg_paths=msg_paths) as graphs:
            for line in graphs.lines:
                report(Level.INFO, line)
            async with open_gateway(graphs, report) as gateway:
                await gateway.wait_ended()

    run(serve(), is_service=True)
