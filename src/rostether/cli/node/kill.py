"""`rostether node kill` and `node cleanup`: ending nodes, and forgetting those that have ended unseen."""

from __future__ import annotations

import sys

import click

from rostether.cli.access.completions import complete_nodes
from rostether.cli.access.options import master_option
from rostether.cli.access.refusals import not_on_ros2
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.failures import EXIT_FAILED, one_line
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import GraphError, UnknownNameError


@click.command(
    "kill", cls=Verb, examples="rostether node kill /talker\nrostether node kill -a\nrostether node kill"
)
@click.argument("names", metavar="[NODE]...", nargs=-1, shell_complete=complete_nodes)
@click.option("-a", "--all", "kill_all", is_flag=True, help="Shut down every node.")
@master_option
@ros1_option
@ros2_option
def kill(names: tuple[str, ...], kill_all: bool, master: str | None) -> None:
    """Ask nodes to shut down; without a name, choose one from a list."""
    if chosen_ros2() is not None:
        raise not_on_ros2("node kill", "nobody can end a node of ROS 2 from outside; end its process")
    if kill_all and names:
        raise click.UsageError("--all shuts every node down: leave the names out")
    chosen = run(_resolve_running(names, master))
    if not names and not kill_all:
        chosen = [_choose(chosen)] if chosen else []
    if not chosen:
        write_line("No nodes running")
        return
    listed = "".join(f"\n * {name}" for name in chosen)
    write_line(f"killing:{listed}" if len(chosen) > 1 else f"killing {chosen[0]}")
    if failed := run(_kill(chosen, master)):
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


async def _resolve_running(names: tuple[str, ...], master: str | None) -> list[str]:
    """Return the full names; of all nodes when none is given. Raises UnknownNameError for one unknown."""
    from rostether.cli.access.ros1_access import master_client, read_environment, resolve
    from rostether.cli.node.calls import node_names, unknown_node

    environment = read_environment(master)
    async with master_client(environment) as client:
        running = await node_names(client)
    wanted = [resolve(name, environment) for name in names]
    for name in wanted:
        if name not in running:
            raise unknown_node(name, running)
    return wanted or running


async def _kill(names: list[str], master: str | None) -> list[tuple[str, str]]:
    """Ask each node to shut down; returns those that could not be asked, with the reason."""
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.node.calls import ask, node_client

    failed = []
    async with master_client(read_environment(master)) as client:
        for name in names:
            try:
                async with node_client(name, await client.lookup_node(name)) as peer:
                    await ask(peer, "shutdown", "user request")
            except UnknownNameError:
                # It ended by itself in the meantime.
                continue
            except GraphError as error:
                # A node may hang up while it answers: only one that cannot be reached was not asked.
                if isinstance(error.__cause__, ConnectionRefusedError):
                    failed.append((name, "it is gone already; `rostether node cleanup` forgets it"))
                elif error.__cause__ is None:
                    failed.append((name, one_line(error)))
    return failed


@click.command("cleanup", cls=Verb, examples="rostether node cleanup\nrostether node cleanup --yes")
@click.option("-y", "--yes", is_flag=True, help="Do not ask.")
@master_option
@ros1_option
@ros2_option
def cleanup(yes: bool, master: str | None) -> None:
    """Have the master forget nodes that do not answer, after asking whether it should."""
    if chosen_ros2() is not None:
        raise not_on_ros2("node cleanup", "ROS 2 forgets nodes that are gone by itself")
    silent = run(_silent(master))
    if not silent:
        return
    write_line("Unable to contact the following nodes:")
    write_line("\n".join(f" * {name}" for name in silent))
    write_line("Warning: these might include alive and functioning nodes, e.g. in unstable networks.")
    write_line("Cleanup will purge all information about these nodes from the master.")
    if not yes and not _is_confirmed():
        write_line("aborting")
        return
    run(_forget(silent, master))
    write_line("done")


def _is_confirmed() -> bool:
    write_line("Please type y or n to continue:")
    for line in sys.stdin:
        if line.strip() in ("y", "n"):
            return line.strip() == "y"
    raise click.Abort


async def _silent(master: str | None) -> dict[str, str]:
    """Ping every node; returns the URI of each that did not answer."""
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.node.calls import node_names, ping

    silent = {}
    async with master_client(read_environment(master)) as client:
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


async def _forget(nodes: dict[str, str], master: str | None) -> None:
    from rostether.cli.access.ros1_access import master_client, read_environment

    environment = read_environment(master)
    async with master_client(environment) as client:
        publishers, subscribers, services = await client.system_state()
        for name, uri in nodes.items():
            write_line(f"Unregistering {name}")
            # Registrations belong to a node: the master takes them back in its name.
            async with master_client(environment, name) as in_its_name:
                for topic in (topic for topic, names in publishers.items() if name in names):
                    await in_its_name.unregister_publisher(topic, uri)
                for topic in (topic for topic, names in subscribers.items() if name in names):
                    await in_its_name.unregister_subscriber(topic, uri)
                for service in (service for service, names in services.items() if name in names):
                    await in_its_name.unregister_service(service, await client.lookup_service(service))
