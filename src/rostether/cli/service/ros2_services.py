"""`rostether service` on a ROS 2 graph, with the output of `ros2 service`."""

from __future__ import annotations

import asyncio
import re
import time
from pathlib import Path

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros1_only
from rostether.cli.access.ros2_tool_node import ToolNode, asked, tool_node
from rostether.cli.service.options import CallOptions, ServiceListing
from rostether.cli.shell.output import write_json, write_line, write_result
from rostether.errors import ServiceUnavailableError, UnknownNameError
from rostether.graph.ros_clock import wall_time
from rostether.mechanisms.text import did_you_mean, escape_line
from rostether.names.graph_name import is_in_namespace
from rostether.ros2.endpoint_info import EndpointKind
from rostether.ros2.graph_view import SERVICE_KINDS, GraphView, one_or_all
from rostether.ros2.types.message_text import MessageText, TextStyle
from rostether.ros2.types.native_registry import short_name

_TYPE_NAME = re.compile(r"[A-Za-z]\w*(/srv)?/[A-Za-z]\w*")
# How often the graph is checked for the service.
POLL_S = 0.1


class Ros2Services:
    """The services of a ROS 2 graph; each method is a whole command."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph

    async def list_services(self, wanted: ServiceListing) -> None:
        """Print the services."""
        view = await asked(self._graph, lambda tool: tool.settled_snapshot())
        names = view.services(with_hidden=wanted.with_hidden)
        if wanted.namespace is not None:
            namespace = f"/{wanted.namespace.strip('/')}"
            names = [name for name in names if is_in_namespace(name, namespace)]
        if wanted.count_services:
            write_line(str(len(names)))
            return
        for name in names:
            types, nodes = view.types([EndpointKind.SERVER], name), servers_of(view, name)
            if wanted.as_json:
                write_json({"service": name, "type": one_or_all(types), "nodes": nodes})
            else:
                shown = f" [{', '.join(types)}]" if wanted.show_types else ""
                write_line(escape_line(f"{name}{shown}{' ' + ','.join(nodes) if wanted.nodes else ''}"))

    async def type_of(self, service: str) -> None:
        """Print the type of a service, or each of them."""
        name, view = await _view_of(self._graph, service)
        for each in view.types([EndpointKind.SERVER], name):
            write_line(escape_line(each))

    async def node_of(self, service: str) -> None:
        """Print the nodes that offer a service."""
        name, view = await _view_of(self._graph, service)
        for each in servers_of(view, name):
            write_line(escape_line(each))

    async def args(self, service: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the names of a service's arguments."""
        from rostether.msgdef.search_waiting import wait_for_definitions
        from rostether.ros2.types.native_registry import NativeRegistry

        name, view = await _view_of(self._graph, service)
        type_name = view.types([EndpointKind.SERVER], name)[0]
        registry = NativeRegistry.from_environment(msg_paths)
        definition = await wait_for_definitions(registry, lambda: registry.ros2_service(type_name))
        write_line(" ".join(field.name for field in definition.request.fields))

    async def info(self, service: str, msg_paths: tuple[Path, ...], *, as_json: bool) -> None:
        """Print a service's type and the numbers of clients and servers."""
        name, view = await _view_of(self._graph, service)
        shown_type = view.shown_type([EndpointKind.SERVER], name)
        ends = {kind: view.of(kind, name) for kind in SERVICE_KINDS}
        if as_json:
            nodes = {kind: [end.node_name for end in found] for kind, found in ends.items()}
            write_json(
                {
                    "service": name,
                    "type": shown_type,
                    "servers": nodes[EndpointKind.SERVER],
                    "clients": nodes[EndpointKind.CLIENT],
                }
            )
            return
        write_line(f"Type: {shown_type}")
        write_line(f"Clients count: {len(ends[EndpointKind.CLIENT])}")
        write_line(f"Services count: {len(ends[EndpointKind.SERVER])}")

    async def find(self, type_name: str) -> None:
        """Print the services of a type."""
        view = await asked(self._graph, lambda tool: tool.settled_snapshot())
        for name in view.services():
            if short_name(type_name) in map(short_name, view.types([EndpointKind.SERVER], name)):
                write_line(escape_line(name))

    async def call(self, service: str, values: tuple[str, ...], options: CallOptions) -> None:
        """Call a service as `ros2 service call` does.

        Raises GraphError, UnknownTypeError, SerializationError naming the field.
        """
        from rostether.serde.plain_form import to_plain
        from rostether.serde.yaml_form import fill_or_default, load_arguments

        refuse_ros1_only(verbose=options.verbose)
        type_name = values[0] if values and _TYPE_NAME.fullmatch(values[0]) else None
        # An empty argument is the empty text; YAML would read it as null.
        fields = load_arguments([each or "''" for each in values[1 if type_name else 0 :]])
        async with tool_node(self._graph, options.msg_paths) as tool:
            name = tool.graph.resolve(service)
            view = await _wait_for_server(tool, name, options)
            chosen = short_name(type_name or view.types([EndpointKind.SERVER], name)[0])
            await tool.learn_type(view, name, EndpointKind.SERVER)
            definition = tool.registry.ros2_service(chosen)
            codec = tool.graph.store.codec(tool.registry.service_type(chosen).request.name)
            text = MessageText(tool.registry.ros2_message, TextStyle(truncate_length=None))
            request = fill_or_default(codec, fields, now=wall_time)
            while True:
                begin_s = time.monotonic()
                if not options.as_json:
                    write_line(f"requester: making request: {text.python(request, definition.request)}\n")
                response = await tool.graph.call(name, chosen, request, timeout_s=options.timeout_s)
                write_result(
                    to_plain(response),
                    f"response:\n{text.python(response, definition.response)}\n",
                    as_json=options.as_json,
                )
                if options.rate_hz is None:
                    return
                await asyncio.sleep(max(begin_s + 1 / options.rate_hz - time.monotonic(), 0.0))


def servers_of(view: GraphView, service: str) -> list[str]:
    """Return the nodes that offer a service."""
    return sorted({end.node_name for end in view.of(EndpointKind.SERVER, service)})


async def _view_of(graph: GraphOptions, service: str) -> tuple[str, GraphView]:
    """Return a service's full name and the graph it is in. Raises UnknownNameError."""

    async def ask(tool: ToolNode) -> tuple[str, GraphView]:
        name = tool.graph.resolve(service)
        await tool.snapshot_when(lambda seen: bool(seen.of(EndpointKind.SERVER, name)))
        return name, await tool.settled_snapshot()

    name, view = await asked(graph, ask)
    if not view.of(EndpointKind.SERVER, name):
        hint = did_you_mean(name, view.services()) or "`rostether service list` shows all services"
        raise UnknownNameError(f"Unknown service '{name}': no node offers it; {hint}")
    return name, view


async def _wait_for_server(tool: ToolNode, service: str, options: CallOptions) -> GraphView:
    """Return the graph as soon as a service is offered. Raises ServiceUnavailableError."""
    begin_s = time.monotonic()
    reported = options.as_json
    while True:
        view = await tool.snapshot()
        if view.types([EndpointKind.SERVER], service):
            return view
        waited_s = time.monotonic() - begin_s
        if options.timeout_s is not None and waited_s > options.timeout_s:
            raise ServiceUnavailableError(
                f"no node offered the service {service} within {options.timeout_s:g} s; "
                "`rostether service list` shows those that are offered"
            )
        if not reported and waited_s > POLL_S:
            reported = True
            write_line("waiting for service to become available...")
        await asyncio.sleep(POLL_S)
