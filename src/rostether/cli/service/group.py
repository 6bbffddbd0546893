"""`rostether service`: which services there are, and what they take, as rosservice shows it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.completions import complete_service_types, complete_services
from rostether.cli.access.options import master_option, msg_path_option
from rostether.cli.access.refusals import not_on_ros2, refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import LazyGroup, Verb, VerbEntry
from rostether.errors import ServiceUnavailableError, UnknownNameError

if TYPE_CHECKING:
    from rostether.ros1.node.master_client import MasterClient

_HERE = "rostether.cli.service.group:"
_VERBS = {
    "list": VerbEntry(f"{_HERE}list_services", "List the services."),
    "info": VerbEntry(f"{_HERE}info", "Show who offers a service, its type and its arguments."),
    "call": VerbEntry("rostether.cli.service.call:call", "Call a service and print its response."),
    "type": VerbEntry(f"{_HERE}type_of", "Print the type of a service."),
    "args": VerbEntry(f"{_HERE}args", "Print the names of a service's arguments."),
    "find": VerbEntry(f"{_HERE}find", "List the services of a type."),
    "node": VerbEntry(f"{_HERE}node_of", "Print the node that offers a service."),
    "uri": VerbEntry(f"{_HERE}uri_of", "Print the URI of a service."),
}

_service_argument = click.argument("service", shell_complete=complete_services)


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether service list
    rostether service call /set_led "data: true"
    rostether service type /set_led | rostether srv show
    """,
)
def service() -> None:
    """List, show and call the services of a ROS graph."""


@click.command("list", cls=Verb, examples="rostether service list\nrostether service list -n /demo_board")
@click.argument("namespace", required=False, shell_complete=complete_services)
@click.option("-n", "--nodes", is_flag=True, help="Print the nodes that offer them, too.")
@click.option("-t", "--show-types", is_flag=True, help="With --ros2, show types.")
@click.option("-c", "--count-services", is_flag=True, help="Only print how many there are.")
@click.option(
    "--include-hidden-services", "with_hidden", is_flag=True, help="With --ros2, hidden services (_name) too."
)
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def list_services(
    namespace: str | None,
    nodes: bool,
    show_types: bool,
    count_services: bool,
    with_hidden: bool,
    as_json: bool,
    master: str | None,
) -> None:
    """List the services, of all or of a namespace."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_service as ros2

        refuse_ros1_only(master=master)
        ros2.list_services(
            middleware,
            namespace,
            show_types=show_types,
            count_only=count_services,
            with_nodes=nodes,
            with_hidden=with_hidden,
            as_json=as_json,
        )
        return
    refuse_ros2_only(show_types=show_types, with_hidden=with_hidden)
    if count_services:
        write_line(str(len(run(_services(namespace, master)))))
        return
    for name, providers in run(_services(namespace, master)):
        if as_json:
            write_json({"service": name, "nodes": providers})
        else:
            write_line(f"{name} {','.join(providers)}" if nodes else name)


async def _services(namespace: str | None, master: str | None) -> list[tuple[str, list[str]]]:
    from rostether.cli.access.ros1_access import in_namespace, master_client, read_environment, resolve

    environment = read_environment(master)
    within = resolve(namespace, environment) if namespace is not None else "/"
    async with master_client(environment) as client:
        services = (await client.system_state())[2]
    return sorted(
        (name, nodes) for name, nodes in services.items() if within == "/" or in_namespace(name, within)
    )


async def _ask(
    question: Callable[[MasterClient, str], Awaitable[str]], service: str, master: str | None
) -> str:
    from rostether.cli.access.ros1_access import master_client, read_environment, resolve

    environment = read_environment(master)
    async with master_client(environment) as client:
        return await question(client, resolve(service, environment))


@click.command("type", cls=Verb, examples="rostether service type /set_led")
@_service_argument
@master_option
@ros1_option
@ros2_option
@daemon_habits
def type_of(service: str, master: str | None) -> None:
    """Print the type of a service."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_service as ros2

        refuse_ros1_only(master=master)
        ros2.type_of(middleware, service)
        return
    from rostether.cli.service.probe import probe_type

    write_line(run(_ask(probe_type, service, master)))


@click.command("uri", cls=Verb, examples="rostether service uri /set_led")
@_service_argument
@master_option
@ros1_option
@ros2_option
@daemon_habits
def uri_of(service: str, master: str | None) -> None:
    """Print the URI (rosrpc://host:port) of a service."""
    if chosen_ros2() is not None:
        raise not_on_ros2(
            "service uri", "services of ROS 2 have no URI; `rostether service info` tells of them"
        )
    from rostether.cli.service.probe import look_up

    write_line(run(_ask(look_up, service, master)))


@click.command("node", cls=Verb, examples="rostether service node /set_led")
@_service_argument
@master_option
@ros1_option
@ros2_option
@daemon_habits
def node_of(service: str, master: str | None) -> None:
    """Print the node that offers a service."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_service as ros2

        refuse_ros1_only(master=master)
        ros2.node_of(middleware, service)
        return
    from rostether.cli.service.probe import provider

    write_line(run(_ask(provider, service, master)))


@click.command("args", cls=Verb, examples="rostether service args /set_led")
@_service_argument
@msg_path_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def args(service: str, msg_paths: tuple[Path, ...], master: str | None) -> None:
    """Print the names of a service's arguments."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_service as ros2

        refuse_ros1_only(master=master)
        ros2.args(middleware, service, msg_paths)
        return
    from rostether.cli.service.probe import probe_type

    write_line(_argument_names(run(_ask(probe_type, service, master)), msg_paths))


def _argument_names(type_name: str, msg_paths: tuple[Path, ...]) -> str:
    from rostether.msgdef.registry import Registry

    fields = Registry.from_environment(msg_paths).service(type_name).request.fields
    return " ".join(field.name for field in fields)


@click.command("info", cls=Verb, examples="rostether service info /set_led")
@_service_argument
@json_option
@msg_path_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def info(service: str, as_json: bool, msg_paths: tuple[Path, ...], master: str | None) -> None:
    """Show who offers a service, its type and its arguments."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_service as ros2

        refuse_ros1_only(master=master)
        ros2.info(middleware, service, as_json=as_json)
        return
    run(_info(service, as_json, msg_paths, master))


async def _info(service: str, as_json: bool, msg_paths: tuple[Path, ...], master: str | None) -> None:
    from rostether.cli.access.ros1_access import master_client, read_environment, resolve
    from rostether.cli.service.probe import look_up, probe_uri, provider

    environment = read_environment(master)
    name = resolve(service, environment)
    async with master_client(environment) as client:
        node, uri = await provider(client, name), await look_up(client, name)
    if not as_json:
        write_line(f"Node: {node}\nURI: {uri}")
    type_name = await probe_uri(name, uri)
    if not as_json:
        write_line(f"Type: {type_name}")
    arguments = _argument_names(type_name, msg_paths)
    if as_json:
        record = {"service": name, "node": node, "uri": uri, "type": type_name, "args": arguments.split()}
        write_json(record)
    else:
        write_line(f"Args: {arguments}")


@click.command("find", cls=Verb, examples="rostether service find std_srvs/SetBool")
@click.argument("type_name", metavar="TYPE", shell_complete=complete_service_types)
@master_option
@ros1_option
@ros2_option
@daemon_habits
def find(type_name: str, master: str | None) -> None:
    """List the services of a type."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_service as ros2

        refuse_ros1_only(master=master)
        ros2.find(middleware, type_name)
        return
    for name in run(_find(type_name, master)):
        write_line(name)


async def _find(type_name: str, master: str | None) -> list[str]:
    import asyncio

    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.service.probe import probe_type

    async with master_client(read_environment(master)) as client:

        async def has_type(name: str) -> bool:
            try:
                return await probe_type(client, name) == type_name
            except (ServiceUnavailableError, UnknownNameError):
                return False

        names = sorted((await client.system_state())[2])
        matches = await asyncio.gather(*map(has_type, names))
    return [name for name, matched in zip(names, matches, strict=True) if matched]
