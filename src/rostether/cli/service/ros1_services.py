"""`rostether service` on a ROS 1 graph, as rosservice does it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.refusals import refuse_ros2_only
from rostether.cli.access.ros1_access import in_namespace, master_client, read_environment, resolve
from rostether.cli.service.ros1_probe import look_up, probe_type, probe_uri, provider
from rostether.cli.service.services import CallOptions, ServiceListing
from rostether.cli.shell.output import write_json, write_line
from rostether.cli.shell.running import run
from rostether.errors import ServiceUnavailableError, UnknownNameError
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient


class Ros1Services:
    """The services of a ROS 1 graph."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph
        self._environment = read_environment(graph)

    def list_services(self, wanted: ServiceListing) -> None:
        """Print the services."""
        refuse_ros2_only(show_types=wanted.show_types, with_hidden=wanted.with_hidden)
        services = run(_services(self._environment, wanted.namespace))
        if wanted.count_services:
            write_line(str(len(services)))
            return
        for name, providers in services:
            if wanted.as_json:
                write_json({"service": name, "nodes": providers})
            else:
                write_line(f"{name} {','.join(providers)}" if wanted.nodes else name)

    def type_of(self, service: str) -> None:
        """Print the type of a service."""
        write_line(self._ask(probe_type, service))

    def uri_of(self, service: str) -> None:
        """Print the URI of a service."""
        write_line(self._ask(look_up, service))

    def node_of(self, service: str) -> None:
        """Print the node that offers a service."""
        write_line(self._ask(provider, service))

    def args(self, service: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the names of a service's arguments."""
        write_line(_argument_names(self._ask(probe_type, service), msg_paths))

    def info(self, service: str, msg_paths: tuple[Path, ...], *, as_json: bool) -> None:
        """Print which node offers a service, its URI, its type and its arguments."""
        run(_info(self._environment, service, msg_paths, as_json=as_json))

    def find(self, type_name: str) -> None:
        """Print the services of a type."""
        for name in run(_find(self._environment, type_name)):
            write_line(name)

    def call(self, service: str, values: tuple[str, ...], options: CallOptions) -> None:
        """Call a service and print its response."""
        from rostether.cli.service.ros1_call import call

        refuse_ros2_only(rate_hz=options.rate_hz)
        run(call(self._graph, service, values, options))

    def _ask(self, question: Callable[[MasterClient, str], Awaitable[str]], service: str) -> str:
        async def ask() -> str:
            async with master_client(self._environment) as client:
                return await question(client, resolve(service, self._environment))

        return run(ask())


async def _services(environment: RosEnvironment, namespace: str | None) -> list[tuple[str, list[str]]]:
    within = resolve(namespace, environment) if namespace is not None else "/"
    async with master_client(environment) as client:
        services = (await client.system_state())[2]
    return sorted(
        (name, nodes) for name, nodes in services.items() if within == "/" or in_namespace(name, within)
    )


def _argument_names(type_name: str, msg_paths: tuple[Path, ...]) -> str:
    from rostether.msgdef.registry import Registry

    fields = Registry.from_environment(msg_paths).service(type_name).request.fields
    return " ".join(field.name for field in fields)


async def _info(
    environment: RosEnvironment, service: str, msg_paths: tuple[Path, ...], *, as_json: bool
) -> None:
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


async def _find(environment: RosEnvironment, type_name: str) -> list[str]:
    async with master_client(environment) as client:

        async def has_type(name: str) -> bool:
            try:
                return await probe_type(client, name) == type_name
            except (ServiceUnavailableError, UnknownNameError):
                return False

        names = sorted((await client.system_state())[2])
        matches = await asyncio.gather(*map(has_type, names))
    return [name for name, matched in zip(names, matches, strict=True) if matched]
