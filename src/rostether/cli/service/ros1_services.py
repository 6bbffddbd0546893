"""`rostether service` on a ROS 1 graph, as rosservice does it."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros2_only
from rostether.cli.access.ros1_access import joined, master_client, read_environment, resolve
from rostether.cli.service.options import CallOptions, ServiceListing
from rostether.cli.shell.input import piped_documents
from rostether.cli.shell.output import write_json, write_line, write_result
from rostether.cli.shell.own_command import called_as
from rostether.errors import ServiceUnavailableError, UnknownNameError
from rostether.names.graph_name import is_in_namespace
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.service_probe import look_up, probe_type, probe_uri, provider

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.serde.values import Message

# How often `--wait` asks the master for the service.
WAIT_POLL_S = 0.2


class Ros1Services:
    """The services of a ROS 1 graph; each method is a whole command."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph
        self._environment = read_environment(graph)

    async def list_services(self, wanted: ServiceListing) -> None:
        """Print the services."""
        refuse_ros2_only(show_types=wanted.show_types, with_hidden=wanted.with_hidden)
        within = "/" if wanted.namespace is None else resolve(wanted.namespace, self._environment)
        async with master_client(self._environment) as client:
            offered = (await client.system_state())[2]
        services = sorted(
            each for each in offered.items() if within == "/" or is_in_namespace(each[0], within)
        )
        if wanted.count_services:
            write_line(str(len(services)))
            return
        for name, providers in services:
            write_result(
                {"service": name, "nodes": providers},
                f"{name} {','.join(providers)}" if wanted.nodes else name,
                as_json=wanted.as_json,
            )

    async def type_of(self, service: str) -> None:
        """Print the type of a service."""
        write_line(await self._ask(probe_type, service))

    async def uri_of(self, service: str) -> None:
        """Print the URI of a service."""
        write_line(await self._ask(look_up, service))

    async def node_of(self, service: str) -> None:
        """Print the node that offers a service."""
        write_line(await self._ask(provider, service))

    async def args(self, service: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the names of a service's arguments."""
        write_line(await _argument_names(await self._ask(probe_type, service), msg_paths))

    async def info(self, service: str, msg_paths: tuple[Path, ...], *, as_json: bool) -> None:
        """Print which node offers a service, its URI, its type and its arguments."""
        name = resolve(service, self._environment)
        async with master_client(self._environment) as client:
            node, uri = await provider(client, name), await look_up(client, name)
        show: Callable[[str], None] = (lambda _: None) if as_json else write_line
        show(f"Node: {node}\nURI: {uri}")
        type_name = await probe_uri(name, uri)
        show(f"Type: {type_name}")
        arguments = await _argument_names(type_name, msg_paths)
        record = {"service": name, "node": node, "uri": uri, "type": type_name, "args": arguments.split()}
        write_result(record, f"Args: {arguments}", as_json=as_json)

    async def find(self, type_name: str) -> None:
        """Print the services of a type."""
        async with master_client(self._environment) as client:

            async def has_type(name: str) -> bool:
                try:
                    return await probe_type(client, name) == type_name
                except (ServiceUnavailableError, UnknownNameError):
                    return False

            names = sorted((await client.system_state())[2])
            matches = await asyncio.gather(*map(has_type, names))
        found = [name for name, matched in zip(names, matches, strict=True) if matched]
        # rosservice writes an empty line.
        if found or called_as() == "rosservice":
            write_line("\n".join(found))

    async def call(self, service: str, values: tuple[str, ...], options: CallOptions) -> None:
        """Call a service and print its response.

        Raises GraphError, UnknownTypeError, SerializationError naming the field.
        """
        from rostether.serde.plain_form import to_plain
        from rostether.serde.yaml_print import format_message

        refuse_ros2_only(rate_hz=options.rate_hz)
        name = resolve(service, self._environment)
        async with master_client(self._environment) as client:
            if options.wait:
                await _wait_for_service(client, name, options.timeout_s)
            type_name = await probe_type(client, name)
        # The type may precede the values, as in `ros2 service call`.
        if values and values[0] in (type_name, type_name.replace("/", "/srv/")):
            values = values[1:]
        async with joined(self._graph, options.msg_paths, purpose="rosservice") as graph:
            async for request in _requests(graph, type_name, values):
                response = await graph.call(name, type_name, request, timeout_s=options.timeout_s)
                if options.as_json:
                    write_json(to_plain(response))
                    continue
                if options.verbose:
                    write_line(f"{format_message(request)}\n---")
                write_line(format_message(response))

    async def _ask(self, question: Callable[[MasterClient, str], Awaitable[str]], service: str) -> str:
        async with master_client(self._environment) as client:
            return await question(client, resolve(service, self._environment))


async def _argument_names(type_name: str, msg_paths: tuple[Path, ...]) -> str:
    from rostether.msgdef.registry import Registry
    from rostether.msgdef.search_waiting import wait_for_definitions

    registry = Registry.from_environment(msg_paths)
    service = await wait_for_definitions(registry, lambda: registry.service(type_name))
    return " ".join(field.name for field in service.request.fields)


async def _requests(graph: TypedGraph, type_name: str, arguments: tuple[str, ...]) -> AsyncIterator[Message]:
    from rostether.serde.yaml_form import parse_documents, parse_values

    request_type = graph.store.registry.service_type(type_name).request.name
    codec = graph.store.codec(request_type)
    # An empty argument is the empty text; YAML would read it as null.
    texts = [argument or "''" for argument in arguments]
    if texts or not codec.message_class._fields:
        yield parse_values(codec, texts, now=graph.now)
        return
    is_any = False
    if not sys.stdin.isatty():
        async for text in piped_documents(sys.stdin):
            for request in parse_documents(codec, text, now=graph.now):
                is_any = True
                yield request
    if not is_any:
        fields = ", ".join(f"{name}: {field_type}" for name, field_type in codec.message_class._fields)
        raise click.UsageError(f"give the request as YAML; the fields of {type_name} are {{{fields}}}")


async def _wait_for_service(client: MasterClient, name: str, timeout_s: float | None) -> None:
    try:
        async with asyncio.timeout(timeout_s):
            while True:
                try:
                    await client.lookup_service(name)
                except UnknownNameError:
                    await asyncio.sleep(WAIT_POLL_S)
                else:
                    return
    except TimeoutError:
        raise ServiceUnavailableError(
            f"no node offered the service {name} within {timeout_s:g} s; "
            "`rostether service list` shows those that are offered"
        ) from None
