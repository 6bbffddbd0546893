"""`rostether node list|info|ping|kill|cleanup|machine`: the nodes of a graph."""

from __future__ import annotations

import click

from rostether.cli.access.completions import complete_nodes
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import daemon_habits
from rostether.cli.node.nodes import NodeListing, nodes_of
from rostether.cli.shell.option_group import COUNT, option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import Verb


@click.command(
    "list", cls=Verb, examples="rostether node list\nrostether node list -a\nrostether node list /robot1"
)
@option_group("wanted", NodeListing)
@graph_options()
@daemon_habits
def list_nodes(wanted: NodeListing, graph: GraphOptions) -> None:
    """List all running nodes, or those in a namespace."""
    nodes_of(graph).list_nodes(wanted)


@click.command("info", cls=Verb, examples="rostether node info /board\nrostether node info -q /board /rosout")
@click.argument("nodes", metavar="NODE...", nargs=-1, required=True, shell_complete=complete_nodes)
@click.option(
    "-q", "--quiet", is_flag=True, help="Show only the master's information; do not ask the node itself."
)
@click.option("--include-hidden", "with_hidden", is_flag=True, help="With --ros2, also hidden names (_name).")
@json_option
@graph_options()
@daemon_habits
def info(nodes: tuple[str, ...], quiet: bool, with_hidden: bool, as_json: bool, graph: GraphOptions) -> None:
    """Show what a node publishes, subscribes to and serves, and its connections."""
    nodes_of(graph).info(nodes, quiet=quiet, with_hidden=with_hidden, as_json=as_json)


@click.command("machine", cls=Verb, examples="rostether node machine\nrostether node machine robot.local")
@click.argument("name", required=False, metavar="[MACHINE]")
@graph_options()
@daemon_habits
def machine(name: str | None, graph: GraphOptions) -> None:
    """List the machines that nodes run on, or the nodes on one of them."""
    nodes_of(graph).machine(name)


@click.command(
    "ping",
    cls=Verb,
    examples="""
    rostether node ping /board
    rostether node ping -c 3 /board
    rostether node ping --all
    """,
)
@click.argument("name", metavar="[NODE]", required=False, shell_complete=complete_nodes)
@click.option("-a", "--all", "ping_all", is_flag=True, help="Ping each node once.")
@click.option("-n", "-c", "--count", type=COUNT, metavar="COUNT", help="Stop after COUNT pings.")
@json_option
@graph_options()
def ping(name: str | None, ping_all: bool, count: int | None, as_json: bool, graph: GraphOptions) -> None:
    """Ping a node once a second until Ctrl-C; the exit code is 1 if it does not answer."""
    nodes = nodes_of(graph)
    if ping_all and (name or count):
        raise click.UsageError("with --all, omit the node's name and -c")
    if name is None and not ping_all:
        raise click.UsageError(
            "give a node; `rostether node list` shows the running nodes; --all pings them all"
        )
    nodes.ping(name, count, as_json=as_json)


@click.command(
    "kill", cls=Verb, examples="rostether node kill /talker\nrostether node kill -a\nrostether node kill"
)
@click.argument("names", metavar="[NODE]...", nargs=-1, shell_complete=complete_nodes)
@click.option("-a", "--all", "kill_all", is_flag=True, help="Shut down every node.")
@graph_options()
def kill(names: tuple[str, ...], kill_all: bool, graph: GraphOptions) -> None:
    """Ask nodes to shut down; without a name, choose one from a list."""
    nodes = nodes_of(graph)
    if kill_all and names:
        raise click.UsageError("with --all, omit the names")
    nodes.kill(names, kill_all=kill_all)


@click.command("cleanup", cls=Verb, examples="rostether node cleanup\nrostether node cleanup --yes")
@click.option("-y", "--yes", is_flag=True, help="Do not ask.")
@graph_options()
def cleanup(yes: bool, graph: GraphOptions) -> None:
    """Unregister nodes that do not answer from the master, after confirmation."""
    nodes_of(graph).cleanup(yes=yes)
