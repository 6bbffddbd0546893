"""`rostether node list|info|ping|kill|cleanup|machine`: the nodes of a ROS 1 or ROS 2 graph."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import click

from rostether.cli.access.completions import complete_nodes
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import refuse_ros2
from rostether.cli.shell.failures import EXIT_FAILED
from rostether.cli.shell.option_group import COUNT, add_flag, add_option
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import verb

if TYPE_CHECKING:
    from rostether.ros1.environment import RosEnvironment


class Nodes(Protocol):
    """The nodes of one graph. Each method is a whole command; it raises RostetherError or UsageError."""

    async def list_nodes(
        self, namespace: str, *, uris_only: bool, with_uris: bool, count_nodes: bool, as_json: bool
    ) -> None:
        """Print the nodes."""

    async def info(self, names: tuple[str, ...], *, quiet: bool, with_hidden: bool, as_json: bool) -> None:
        """Print what nodes publish, subscribe to and serve."""


def nodes_of(graph: GraphOptions) -> Nodes:
    """Return the nodes of the graph that the command line selects."""
    if graph.ros2 is None:
        from rostether.cli.node.ros1_nodes import Ros1Nodes

        return Ros1Nodes(graph)
    from rostether.cli.node.ros2_nodes import Ros2Nodes

    return Ros2Nodes(graph)


@verb("list", "rostether node list\nrostether node list -a\nrostether node list /robot1")
@click.argument("namespace", default="")
@add_flag("-u uris_only", "List addresses instead of names.")
@add_flag("-a --all with_uris", "List addresses and names; with --ros2, also hidden nodes.")
@add_flag("-c --count-nodes", "Print only the number.")
@json_option
@graph_options()
async def list_nodes(
    namespace: str, uris_only: bool, with_uris: bool, count_nodes: bool, as_json: bool, graph: GraphOptions
) -> None:
    """List all running nodes, or those in a namespace."""
    await nodes_of(graph).list_nodes(
        namespace, uris_only=uris_only, with_uris=with_uris, count_nodes=count_nodes, as_json=as_json
    )


@verb("info", "rostether node info /board\nrostether node info -q /board /rosout")
@click.argument("nodes", metavar="NODE...", nargs=-1, required=True, shell_complete=complete_nodes)
@add_flag("-q --quiet", "Show only the master's information; do not ask the node itself.")
@add_flag("--include-hidden with_hidden", "With --ros2, include hidden names (_name).")
@json_option
@graph_options()
async def info(
    nodes: tuple[str, ...], quiet: bool, with_hidden: bool, as_json: bool, graph: GraphOptions
) -> None:
    """Show what a node publishes, subscribes to and serves, and its connections."""
    await nodes_of(graph).info(nodes, quiet=quiet, with_hidden=with_hidden, as_json=as_json)


@verb("machine", "rostether node machine\nrostether node machine robot.local")
@click.argument("name", required=False, metavar="[MACHINE]")
@graph_options()
async def list_machines(name: str | None, graph: GraphOptions) -> None:
    """List the machines that nodes run on, or the nodes on one of them."""
    environment = _ros1(graph, "node machine", "ROS 2 does not report where a node runs")
    from rostether.cli.node.ros1_nodes import machine

    await machine(environment, name)


@verb(
    "ping",
    """
    rostether node ping /board
    rostether node ping -c 3 /board
    rostether node ping --all
    """,
)
@click.argument("name", metavar="[NODE]", required=False, shell_complete=complete_nodes)
@add_flag("-a --all of_all", "Ping each node once.")
@add_option("-n -c --count COUNT", "Stop after COUNT pings.", type=COUNT)
@json_option
@graph_options()
async def ping_nodes(
    name: str | None, of_all: bool, count: int | None, as_json: bool, graph: GraphOptions
) -> None:
    """Ping a node once a second until Ctrl-C; the exit code is 1 if it does not answer."""
    environment = _ros1(
        graph, "node ping", "ROS 2 nodes have no address; `rostether node info` shows whether the node exists"
    )
    if of_all and (name or count):
        raise click.UsageError("with --all, omit the node's name and -c")
    if name is None and not of_all:
        raise click.UsageError(
            "give a node; `rostether node list` shows the running nodes; --all pings them all"
        )
    from rostether.cli.node.ros1_ping import ping, ping_all

    if name is None:
        has_answered = await ping_all(environment, as_json=as_json)
    else:
        has_answered = await ping(environment, name, count, as_json=as_json)
    if not has_answered:
        raise click.exceptions.Exit(EXIT_FAILED)


@verb("kill", "rostether node kill /talker\nrostether node kill -a\nrostether node kill")
@click.argument("names", metavar="[NODE]...", nargs=-1, shell_complete=complete_nodes)
@add_flag("-a --all kill_all", "Shut down every node.")
@graph_options()
def kill_nodes(names: tuple[str, ...], kill_all: bool, graph: GraphOptions) -> None:
    """Ask nodes to shut down; without a name, choose one from a list."""
    environment = _ros1(
        graph, "node kill", "ROS 2 nodes cannot be shut down remotely; end the process of the node"
    )
    if kill_all and names:
        raise click.UsageError("with --all, omit the names")
    from rostether.cli.node.ros1_kill import kill

    kill(environment, names, kill_all=kill_all)


@verb("cleanup", "rostether node cleanup\nrostether node cleanup --yes")
@add_flag("-y --yes", "Do not ask.")
@graph_options()
def cleanup_nodes(yes: bool, graph: GraphOptions) -> None:
    """Remove the master's registrations of nodes that do not answer, after confirmation."""
    environment = _ros1(graph, "node cleanup", "ROS 2 removes dead nodes automatically")
    from rostether.cli.node.ros1_kill import cleanup

    cleanup(environment, yes=yes)


def _ros1(graph: GraphOptions, command: str, instead: str) -> RosEnvironment:
    """Return the ROS 1 environment. Raises UsageError with `instead` on ROS 2."""
    refuse_ros2(graph, command, instead)
    from rostether.cli.access.ros1_access import read_environment

    return read_environment(graph)
