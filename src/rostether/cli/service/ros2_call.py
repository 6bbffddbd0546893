"""`service call` on a ROS 2 graph, as `ros2 service call` does it; the type may be left out."""

from __future__ import annotations

import asyncio
import re
import time
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros2_tool_node import tool_node
from rostether.cli.service.services import CallOptions
from rostether.cli.shell.output import write_json, write_line
from rostether.cli.topic.ros2_message_text import MessageText, TextStyle
from rostether.cli.topic.ros2_typed_values import ValueForm
from rostether.errors import ServiceUnavailableError
from rostether.ros2.endpoint_info import EndpointKind
from rostether.ros2.types.native_registry import short_name
from rostether.rostime import Time

if TYPE_CHECKING:
    from rostether.cli.access.ros2_tool_node import ToolNode
    from rostether.cli.access.ros2_view import GraphView

_TYPE_NAME = re.compile(r"[A-Za-z]\w*(/srv)?/[A-Za-z]\w*")
POLL_S = 0.1


async def call(graph: GraphOptions, service: str, arguments: tuple[str, ...], options: CallOptions) -> None:
    """Call and print. Raises GraphError, UnknownTypeError, SerializationError naming the field."""
    from rostether.serde.plain_form import to_plain
    from rostether.serde.yaml_form import load_arguments

    type_name = arguments[0] if arguments and _TYPE_NAME.fullmatch(arguments[0]) else None
    # An empty argument is the empty text; YAML would read it as null.
    values = load_arguments([each or "''" for each in arguments[1 if type_name else 0 :]])
    async with tool_node(graph, options.msg_paths) as tool:
        name = tool.graph.resolve(service)
        view = await _wait_for_server(tool, name, options)
        chosen = short_name(type_name or view.types([EndpointKind.SERVER], name)[0])
        await tool.learn_type(view, name, EndpointKind.SERVER)
        definition = tool.registry.ros2_service(chosen)
        codec = tool.graph.store.codec(tool.registry.service_type(chosen).request.name)
        form = ValueForm(tool.registry.ros2_message, lambda: Time.from_ns(time.time_ns()))
        text = MessageText(tool.registry.ros2_message, TextStyle(truncate_length=None))
        request = form.fill(codec, definition.request, values)
        while True:
            begin_s = time.monotonic()
            if not options.as_json:
                write_line(f"requester: making request: {text.python(request, definition.request)}\n")
            response = await tool.graph.call(name, chosen, request, timeout_s=options.timeout_s)
            if options.as_json:
                write_json(to_plain(response))
            else:
                write_line(f"response:\n{text.python(response, definition.response)}\n")
            if options.rate_hz is None:
                return
            await asyncio.sleep(max(begin_s + 1 / options.rate_hz - time.monotonic(), 0.0))


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
                f"no node offers the service {service} after {options.timeout_s:g} s"
            )
        if not reported and waited_s > POLL_S:
            reported = True
            write_line("waiting for service to become available...")
        await asyncio.sleep(POLL_S)
