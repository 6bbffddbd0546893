"""How the gateways for web pages and viewers join a graph, and what they report."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias

from msgspec import Struct

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import master_client, read_environment, ros1_join, type_store
from rostether.cli.access.served_graphs import ServedGraphs, native_session, served_graphs
from rostether.cli.gateway.node import IsLive, NodeNaming, check_free, ros1_liveness
from rostether.cli.role.node import node_environment
from rostether.cli.shell.running import run
from rostether.graph.ports import JoinGraph, Level
from rostether.mechanisms.backoff import wait_for_master
from rostether.mechanisms.loopback import is_loopback
from rostether.names.remap import Arguments
from rostether.ros1.environment import RosEnvironment, parse_rpc_uri
from rostether.ros1.node.service_probe import look_up, probe_type

if TYPE_CHECKING:
    from rostether.graph.ports import Graph
    from rostether.serde.store import TypeStore

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

    On ROS 1, or both, messages have ROS 1 types, as boards send them; on ROS 2 alone, ROS 2 types.
    """
    if graphs.ros1 is not None:
        yield ros1_gateway_graph(graphs.join, type_store(msg_paths), graphs.ros1)
        return
    from rostether.ros2.types.native_types import NativeClasses
    from rostether.serde.store import TypeStore

    async with native_session(options, msg_paths) as session:
        registry = session.registry
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
