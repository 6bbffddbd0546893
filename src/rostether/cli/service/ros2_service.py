"""`service list|type|find|info|node|args` on a ROS 2 graph, in `ros2 service`'s words."""

from __future__ import annotations

from pathlib import Path

from rostether.cli.access.ros2_tool_node import ToolNode, asked
from rostether.cli.access.ros2_view import SERVICE_KINDS, GraphView
from rostether.cli.access.ros_choice import Middleware
from rostether.cli.shell.output import one_line, write_json, write_line
from rostether.errors import UnknownNameError
from rostether.ros2.endpoint_info import EndpointKind
from rostether.ros2.native_registry import short_name


def list_services(
    middleware: Middleware,
    namespace: str | None,
    *,
    show_types: bool,
    count_only: bool,
    with_nodes: bool,
    with_hidden: bool,
    as_json: bool,
) -> None:
    """Print the services."""
    view = asked(middleware, lambda tool: tool.look_well())
    names = view.services(with_hidden=with_hidden)
    if namespace is not None:
        prefix = f"/{namespace.strip('/')}".rstrip("/") + "/"
        names = [name for name in names if f"{name}/".startswith(prefix)]
    if count_only:
        write_line(str(len(names)))
        return
    for name in names:
        types, nodes = view.types([EndpointKind.SERVER], name), servers_of(view, name)
        if as_json:
            write_json({"service": name, "type": types[0] if len(types) == 1 else types, "nodes": nodes})
        else:
            shown = f" [{', '.join(types)}]" if show_types else ""
            write_line(one_line(f"{name}{shown}{' ' + ','.join(nodes) if with_nodes else ''}"))


def servers_of(view: GraphView, service: str) -> list[str]:
    """Return the nodes that offer a service."""
    return sorted({end.node_name for end in view.of(EndpointKind.SERVER, service)})


def _view_of(middleware: Middleware, service: str) -> tuple[str, GraphView]:
    """Return a service's full name and the graph it is in. Raises UnknownNameError."""

    async def ask(tool: ToolNode) -> tuple[str, GraphView]:
        name = tool.graph.resolve(service)
        await tool.look_until(lambda seen: bool(seen.of(EndpointKind.SERVER, name)))
        return name, await tool.look_well()

    name, view = asked(middleware, ask)
    if not view.of(EndpointKind.SERVER, name):
        raise unknown_service(name)
    return name, view


def unknown_service(name: str) -> UnknownNameError:
    """Return the error for a service that nobody offers."""
    return UnknownNameError(
        f"Unknown service '{name}': nobody offers it; `rostether service list` shows those there are"
    )


def type_of(middleware: Middleware, service: str) -> None:
    """Print the type of a service, or each of them."""
    name, view = _view_of(middleware, service)
    for each in view.types([EndpointKind.SERVER], name):
        write_line(one_line(each))


def node_of(middleware: Middleware, service: str) -> None:
    """Print the nodes that offer a service."""
    name, view = _view_of(middleware, service)
    for each in servers_of(view, name):
        write_line(one_line(each))


def args(middleware: Middleware, service: str, msg_paths: tuple[Path, ...]) -> None:
    """Print the names of a service's arguments."""
    from rostether.ros2.native_registry import NativeRegistry

    name, view = _view_of(middleware, service)
    registry = NativeRegistry.from_environment(msg_paths)
    definition = registry.ros2_service(view.types([EndpointKind.SERVER], name)[0])
    write_line(" ".join(field.name for field in definition.request.fields))


def info(middleware: Middleware, service: str, *, as_json: bool) -> None:
    """Print a service's type, and how many call and offer it."""
    name, view = _view_of(middleware, service)
    types = view.types([EndpointKind.SERVER], name)
    ends = {kind: view.of(kind, name) for kind in SERVICE_KINDS}
    if as_json:
        nodes = {kind: [end.node_name for end in found] for kind, found in ends.items()}
        write_json(
            {
                "service": name,
                "type": types[0] if len(types) == 1 else types,
                "servers": nodes[EndpointKind.SERVER],
                "clients": nodes[EndpointKind.CLIENT],
            }
        )
        return
    write_line(f"Type: {types[0] if len(types) == 1 else types}")
    write_line(f"Clients count: {len(ends[EndpointKind.CLIENT])}")
    write_line(f"Services count: {len(ends[EndpointKind.SERVER])}")


def find(middleware: Middleware, type_name: str) -> None:
    """Print the services of a type."""
    view = asked(middleware, lambda tool: tool.look_well())
    for name in view.services():
        if short_name(type_name) in map(short_name, view.types([EndpointKind.SERVER], name)):
            write_line(one_line(name))
