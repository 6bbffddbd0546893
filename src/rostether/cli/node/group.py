"""`rostether node`: which nodes run, what each does, whether it answers, how to end it; as rosnode does."""

from __future__ import annotations

import click

from rostether.cli.access.completions import complete_nodes
from rostether.cli.access.options import master_option
from rostether.cli.access.refusals import not_on_ros2, refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option, one_line, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import LazyGroup, Verb, VerbEntry

_HERE = "rostether.cli.node.group:"
_VERBS = {
    "list": VerbEntry(f"{_HERE}list_nodes", "List the nodes that run."),
    "info": VerbEntry(f"{_HERE}info", "Show what a node publishes, subscribes to and serves."),
    "ping": VerbEntry("rostether.cli.node.ping:ping", "See whether a node answers, and how quickly."),
    "kill": VerbEntry("rostether.cli.node.kill:kill", "Ask nodes to shut down."),
    "cleanup": VerbEntry("rostether.cli.node.kill:cleanup", "Forget nodes that are gone."),
    "machine": VerbEntry(f"{_HERE}machine", "List machines, or the nodes on one."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether node list
    rostether node info /board
    rostether node ping -a
    """,
)
def node() -> None:
    """List, show, ping and stop the nodes of a ROS graph."""


@click.command(
    "list", cls=Verb, examples="rostether node list\nrostether node list -a\nrostether node list /robot1"
)
@click.argument("namespace", default="")
@click.option("-u", "uris_only", is_flag=True, help="List addresses instead of names.")
@click.option(
    "-a", "--all", "with_uris", is_flag=True, help="List addresses and names; with --ros2 hidden nodes too."
)
@click.option("-c", "--count-nodes", is_flag=True, help="Only print how many there are.")
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def list_nodes(
    namespace: str,
    uris_only: bool,
    with_uris: bool,
    count_nodes: bool,
    as_json: bool,
    master: str | None,
) -> None:
    """List the nodes that run, all of them or those in a namespace."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.node import ros2_node as ros2

        refuse_ros1_only(uris_only=uris_only, master=master)
        ros2.list_nodes(middleware, namespace, with_hidden=with_uris, count_only=count_nodes, as_json=as_json)
        return
    if count_nodes:
        write_line(str(len(run(_list(namespace, master, with_uris=False)))))
        return
    for name, uri in run(_list(namespace, master, with_uris=uris_only or with_uris or as_json)):
        if as_json:
            write_json({"node": name, "uri": uri or None})
        elif with_uris:
            write_line(f"{one_line(uri) or 'unknown address'} \t{one_line(name)}")
        else:
            write_line(one_line(uri or "unknown address" if uris_only else name))


async def _list(namespace: str, master: str | None, *, with_uris: bool) -> list[tuple[str, str]]:
    from rostether.cli.access.ros1_access import in_namespace, master_client, read_environment, resolve
    from rostether.cli.node.calls import node_names
    from rostether.errors import UnknownNameError

    environment = read_environment(master)
    prefix = resolve(namespace, environment) if namespace else "/"
    listed = []
    async with master_client(environment) as client:
        for name in await node_names(client):
            if in_namespace(name, prefix):
                try:
                    listed.append((name, await client.lookup_node(name) if with_uris else ""))
                except UnknownNameError:
                    # It left a moment ago.
                    listed.append((name, ""))
    return listed


@click.command("info", cls=Verb, examples="rostether node info /board\nrostether node info -q /board /rosout")
@click.argument("nodes", metavar="NODE...", nargs=-1, required=True, shell_complete=complete_nodes)
@click.option("-q", "--quiet", is_flag=True, help="Show what the master knows, do not ask the node itself.")
@click.option("--include-hidden", "with_hidden", is_flag=True, help="With --ros2, hidden names (_name) too.")
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def info(nodes: tuple[str, ...], quiet: bool, with_hidden: bool, as_json: bool, master: str | None) -> None:
    """Show what a node publishes, subscribes to and serves, and whom it is connected to."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.node import ros2_node as ros2

        refuse_ros1_only(quiet=quiet, master=master)
        ros2.info(middleware, nodes, with_hidden=with_hidden, as_json=as_json)
        return
    refuse_ros2_only(with_hidden=with_hidden)
    run(_info(nodes, master, quiet=quiet, as_json=as_json))


async def _info(nodes: tuple[str, ...], master: str | None, *, quiet: bool, as_json: bool) -> None:
    from rostether.cli.access.ros1_access import master_client, read_environment, resolve
    from rostether.cli.node import report as node_report
    from rostether.cli.node.calls import ask, connections, find_node, node_client, registrations

    environment = read_environment(master)
    async with master_client(environment) as client:
        for each in nodes:
            name = resolve(each, environment)
            uri = await find_node(client, name)
            registered = await registrations(client, name)
            if not as_json:
                write_line(node_report.format_registrations(name, registered))
            if quiet:
                if as_json:
                    write_json(node_report.to_record(name, uri, registered))
                continue
            if not as_json:
                write_line(f"\ncontacting node {uri} ...")
            async with node_client(name, uri) as peer:
                pid = await ask(peer, "getPid")
                connected = await connections(client, peer)
            if as_json:
                write_json(node_report.to_record(name, uri, registered, pid, connected))
            else:
                write_line(node_report.format_connections(pid, connected))


@click.command("machine", cls=Verb, examples="rostether node machine\nrostether node machine robot.local")
@click.argument("name", required=False, metavar="[MACHINE]")
@master_option
@ros1_option
@ros2_option
@daemon_habits
def machine(name: str | None, master: str | None) -> None:
    """List the machines that nodes run on, or the nodes on one of them."""
    if chosen_ros2() is not None:
        raise not_on_ros2("node machine", "ROS 2 does not tell where a node runs")
    hosts = run(_hosts(master))
    if name is None:
        for host in sorted(set(hosts.values())):
            write_line(host)
        return
    found = [node_name for node_name, host in hosts.items() if host == name]
    for each in found:
        write_line(each)
    if not found:
        warn(f"no node is on {name}; `rostether node machine` lists the machines by the names nodes use")
        raise click.exceptions.Exit(1)


async def _hosts(master: str | None) -> dict[str, str]:
    from rostether.errors import ConfigError
    from rostether.ros1.environment import parse_rpc_uri

    hosts = {}
    for name, uri in await _list("", master, with_uris=True):
        try:
            hosts[name] = parse_rpc_uri(uri).host
        except ConfigError:
            continue
    return hosts
