"""`rostether node` on a ROS 1 graph, as rosnode does it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import click
from msgspec.structs import asdict

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros2_only
from rostether.cli.access.ros1_access import master_client, read_environment, resolve
from rostether.cli.shell.failures import EXIT_FAILED, print_error
from rostether.cli.shell.output import warn, write_json, write_line
from rostether.cli.shell.own_command import called_as
from rostether.errors import ConfigError, UnknownNameError
from rostether.mechanisms.text import escape_line
from rostether.msgdef.interface import ANY_TYPE
from rostether.names.graph_name import is_in_namespace
from rostether.ros1.environment import RosEnvironment, parse_rpc_uri
from rostether.ros1.machines import hosts_of_machine
from rostether.ros1.node.node_queries import (
    NodeConnection,
    NodeRegistrations,
    ask,
    connections,
    find_node,
    node_client,
    node_names,
    registrations,
)

_RULE = "-" * 80


class Ros1Nodes:
    """The nodes of a ROS 1 graph; each method is a whole command."""

    def __init__(self, graph: GraphOptions) -> None:
        self._environment = read_environment(graph)

    async def list_nodes(
        self, namespace: str, *, uris_only: bool, with_uris: bool, count_nodes: bool, as_json: bool
    ) -> None:
        """Print the nodes."""
        needs_uris = not count_nodes and (uris_only or with_uris or as_json)
        listed = await _list(self._environment, namespace, with_uris=needs_uris)
        if count_nodes:
            write_line(str(len(listed)))
            return
        for name, uri in listed:
            if as_json:
                write_json({"node": name, "uri": uri or None})
            elif with_uris:
                write_line(f"{escape_line(uri) or 'unknown address'} \t{escape_line(name)}")
            else:
                write_line(escape_line(uri or "unknown address" if uris_only else name))

    async def info(self, names: tuple[str, ...], *, quiet: bool, with_hidden: bool, as_json: bool) -> None:
        """Print what nodes publish, subscribe to and serve, and their connections."""
        refuse_ros2_only(with_hidden=with_hidden)
        is_missing = False
        show: Callable[[str], None] = (lambda _: None) if as_json else write_line
        async with master_client(self._environment) as client:
            for each in names:
                name = resolve(each, self._environment)
                try:
                    uri = await find_node(client, name)
                except UnknownNameError as error:
                    print_error(str(error))
                    is_missing = True
                    continue
                registered = await registrations(client, name)
                show(_format_registrations(name, registered))
                pid: int | None = None
                connected: Sequence[NodeConnection] = ()
                if not quiet:
                    show(f"\ncontacting node {uri} ...")
                    async with node_client(name, uri) as peer:
                        pid, connected = await ask(peer, "getPid"), await connections(client, peer)
                    show(_format_connections(pid, connected))
                if as_json:
                    write_json(_to_record(name, uri, registered, pid, connected))
        # Scripts for rosnode may rely on its exit code: 0 for unknown nodes too.
        if is_missing and called_as() != "rosnode":
            raise click.exceptions.Exit(EXIT_FAILED)


async def machine(environment: RosEnvironment, name: str | None) -> None:
    """Print the machines that nodes run on, or the nodes on one."""
    hosts = {}
    for node, uri in await _list(environment, with_uris=True):
        with suppress(ConfigError):
            hosts[node] = parse_rpc_uri(uri).host
    if name is None:
        for host in sorted(set(hosts.values())):
            write_line(host)
        return
    names = hosts_of_machine(name, hosts.values())
    found = [node_name for node_name, host in hosts.items() if host in names]
    for each in found:
        write_line(each)
    if not found:
        warn(
            f"no node is on {name}; `rostether node machine` lists the machines with the names that nodes use"
        )
        raise click.exceptions.Exit(EXIT_FAILED)


async def _list(
    environment: RosEnvironment, namespace: str = "", *, with_uris: bool
) -> list[tuple[str, str]]:
    prefix = resolve(namespace, environment) if namespace else "/"
    listed = []
    async with master_client(environment) as client:
        for name in await node_names(client):
            if is_in_namespace(name, prefix):
                try:
                    listed.append((name, await client.lookup_node(name) if with_uris else ""))
                except UnknownNameError:
                    # The node has just unregistered.
                    listed.append((name, ""))
    return listed


def _format_registrations(name: str, registered: NodeRegistrations) -> str:
    """Return the part that the master knows."""
    sections = (
        ("Publications", _typed(registered.publications)),
        ("Subscriptions", _typed(registered.subscriptions)),
        ("Services", registered.services),
    )
    return f"{_RULE}\nNode [{name}]\n" + "\n".join(_section(title, lines) for title, lines in sections)


def _format_connections(pid: int | None, connected: Sequence[NodeConnection]) -> str:
    """Return the part that the node itself reported."""
    lines = [f"Pid: {pid}", *(["Connections:"] if connected else [])]
    for each in connected:
        peer = f"{each.peer} ({each.peer_uri})" if each.peer_uri else each.peer
        sockets = " ({} - {}) [{}]".format(*each.sockets) if each.sockets else ""
        lines += [
            f" * topic: {each.topic}",
            f"    * to: {peer}",
            f"    * direction: {each.direction}{sockets}",
            f"    * transport: {each.transport}",
        ]
    return "\n".join(lines) + "\n"


def _to_record(
    name: str, uri: str, registered: NodeRegistrations, pid: int | None, connected: Sequence[NodeConnection]
) -> dict[str, Any]:
    """Return the record for `--json`; `pid` is null when the node was not asked."""
    return {
        "node": name,
        "uri": uri,
        "pid": pid,
        "publications": _records(registered.publications),
        "subscriptions": _records(registered.subscriptions),
        "services": registered.services,
        "connections": [_connection_record(each) for each in connected],
    }


def _connection_record(connection: NodeConnection) -> dict[str, Any]:
    record = asdict(connection)
    port, remote, descriptor = record.pop("sockets") or (None, None, None)
    return {
        **record,
        "local_port": int(port) if port else None,
        "remote_address": remote,
        "descriptor": int(descriptor) if descriptor else None,
    }


def _records(topics: dict[str, str]) -> list[dict[str, str | None]]:
    return [
        {"topic": topic, "type": None if type_name == ANY_TYPE else type_name}
        for topic, type_name in topics.items()
    ]


def _typed(topics: dict[str, str]) -> list[str]:
    return [
        f"{topic} [{'unknown type' if type_name == ANY_TYPE else type_name}]"
        for topic, type_name in topics.items()
    ]


def _section(title: str, lines: list[str]) -> str:
    if not lines:
        return f"{title}: None\n"
    return f"{title}: \n" + "".join(f" * {line}\n" for line in lines)
