"""`node kill` and `node cleanup`: end nodes, and remove the entries of nodes that have crashed."""

from __future__ import annotations

import sys

import click

from rostether.cli.access.ros1_access import master_client, no_master, resolve
from rostether.cli.shell.failures import EXIT_FAILED, error_text
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.running import run
from rostether.errors import GraphError, MasterUnreachableError, ProtocolError, UnknownNameError
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.leftovers import unregister_node
from rostether.ros1.node.node_queries import ask, node_client, node_names, ping, unknown_node
from rostether.xmlrpc.http_message import HttpStatusError
from rostether.xmlrpc.values import FaultError


def kill(environment: RosEnvironment, names: tuple[str, ...], *, kill_all: bool) -> None:
    """Ask nodes to shut down; without names, all with `kill_all`, otherwise the user chooses one.

    Raises UnknownNameError.
    """
    chosen = run(_resolve_running(environment, names))
    if not names and not kill_all:
        chosen = [_choose(chosen)] if chosen else []
    if not chosen:
        write_line("No nodes running")
        return
    listed = "".join(f"\n * {name}" for name in chosen)
    write_line(f"killing:{listed}" if len(chosen) > 1 else f"killing {chosen[0]}")
    if failed := run(_kill(environment, chosen)):
        warn("ERROR: Failed to kill:\n" + "\n".join(f" * {name}: {reason}" for name, reason in failed))
        raise click.exceptions.Exit(EXIT_FAILED)
    write_line("killed")


def _choose(names: list[str]) -> str:
    numbered = "\n".join(f"{number}. {name}" for number, name in enumerate(names, 1))
    write_line(f"{numbered}\n\nPlease enter the number of the node you wish to kill.")
    while True:
        sys.stdout.write("> ")
        sys.stdout.flush()
        line = sys.stdin.readline()
        if not line:
            raise click.Abort
        if line.strip().isdecimal() and 1 <= int(line) <= len(names):
            return names[int(line) - 1]
        warn(f"ERROR: please enter a number from 1 to {len(names)} (ctrl-C to cancel)")


async def _resolve_running(environment: RosEnvironment, names: tuple[str, ...]) -> list[str]:
    """Return the full names, of all nodes if none are given. Raises UnknownNameError for an unknown node."""
    async with master_client(environment) as client:
        running = await node_names(client)
    wanted = [resolve(name, environment) for name in names]
    for name in wanted:
        if name not in running:
            raise unknown_node(name, running)
    return wanted or running


async def _kill(environment: RosEnvironment, names: list[str]) -> list[tuple[str, str]]:
    """Ask each node to shut down; return those that could not be asked, with the reason."""
    failed = []
    async with master_client(environment) as client:
        for name in names:
            try:
                async with node_client(name, await client.lookup_node(name)) as peer:
                    await ask(peer, "shutdown", "user request")
            except UnknownNameError:
                # The node has just unregistered.
                continue
            except GraphError as error:
                cause = error.__cause__
                # A node may close the connection while it answers.
                is_ending = isinstance(cause, ConnectionError | ProtocolError)
                if isinstance(cause, ConnectionRefusedError):
                    failed.append((name, "it is not running; `rostether node cleanup` removes it"))
                elif isinstance(cause, FaultError | HttpStatusError) or not is_ending:
                    failed.append((name, error_text(error)))
    return failed


def cleanup(environment: RosEnvironment, *, yes: bool) -> None:
    """Unregister dead nodes at the master; the user confirms this, unless `yes`."""
    silent = run(_silent(environment))
    if not silent:
        return
    write_line("Unable to contact the following nodes:")
    write_line("\n".join(f" * {name}" for name in silent))
    write_line("Warning: these might include alive and functioning nodes, e.g. in unstable networks.")
    write_line("Cleanup will purge all information about these nodes from the master.")
    if not yes and not _is_confirmed():
        write_line("aborting")
        return
    run(_unregister(environment, silent))
    write_line("done")


def _is_confirmed() -> bool:
    write_line("Please type y or n to continue:")
    for line in sys.stdin:
        if line.strip() in ("y", "n"):
            return line.strip() == "y"
    raise click.Abort


async def _silent(environment: RosEnvironment) -> dict[str, str]:
    """Ping every node; return the URI of each that did not answer."""
    silent = {}
    async with master_client(environment) as client:
        for name in await node_names(client):
            try:
                uri = await client.lookup_node(name)
            except UnknownNameError:
                continue
            try:
                await ping(name, uri)
            except GraphError:
                silent[name] = uri
            else:
                write_line(f"{name} answers")
    return silent


async def _unregister(environment: RosEnvironment, nodes: dict[str, str]) -> None:
    for name, uri in nodes.items():
        write_line(f"Unregistering {name}")
        try:
            await unregister_node(environment.master_uri, name, uri)
        except MasterUnreachableError as error:
            raise no_master(environment, error) from error
