"""`service call` on a ROS 1 graph, as rosservice does it."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import joined, master_client, read_environment, resolve
from rostether.cli.service.ros1_probe import probe_type
from rostether.cli.service.services import CallOptions
from rostether.cli.shell.output import write_json, write_line
from rostether.cli.shell.piped_documents import piped_documents
from rostether.errors import ServiceUnavailableError, UnknownNameError

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.ros1.node.master_client import MasterClient
    from rostether.serde.values import Message

WAIT_POLL_S = 0.2


async def call(
    graph_options: GraphOptions, service: str, values: tuple[str, ...], options: CallOptions
) -> None:
    """Call and print. Raises GraphError, UnknownTypeError, SerializationError naming the field."""
    from rostether.serde.plain_form import to_plain
    from rostether.serde.yaml_print import format_message

    environment = read_environment(graph_options)
    name = resolve(service, environment)
    async with master_client(environment) as client:
        if options.wait:
            await _wait_for_service(client, name, options.timeout_s)
        type_name = await probe_type(client, name)
    async with joined(graph_options, options.msg_paths, purpose="rosservice") as graph:
        async for request in _requests(graph, type_name, values):
            response = await graph.call(name, type_name, request, timeout_s=options.timeout_s)
            if options.as_json:
                write_json(to_plain(response))
                continue
            if options.verbose:
                write_line(f"{format_message(request)}\n---")
            write_line(format_message(response))


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
        raise click.UsageError(f"give the request as YAML: {type_name} takes {{{fields}}}")


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
        raise ServiceUnavailableError(f"no node offers the service {name} after {timeout_s:g} s") from None
