"""`param` on a ROS 2 graph: the parameters of nodes, with the output of `ros2 param`.

A parameter is a node and a name (`/board gain`), or both as one full name (`/board/gain`).
"""

from __future__ import annotations

from array import array
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros1_only
from rostether.cli.access.ros2_tool_node import ToolNode, asked
from rostether.cli.node.ros2_nodes import full_node_name
from rostether.cli.param.options import GetOptions, ParamListing, SetOptions
from rostether.cli.shell.output import warn, write_json, write_line, write_result
from rostether.errors import ConfigError, GraphError, SerializationError, UnknownNameError
from rostether.mechanisms.text import did_you_mean, escape_line
from rostether.names.graph_name import is_hidden
from rostether.ros2.graph_view import GraphView
from rostether.ros2.parameters.parameter_name import name_parts
from rostether.ros2.parameters.typed_value import NOT_SET, ParameterType, TypedValue, typed_value

if TYPE_CHECKING:
    from rostether.ros2.parameters.client import ParameterClient

T = TypeVar("T")

# As in `ros2 param`: "boolean array", "not set".
_TYPE_WORDS = {each: each.name.lower().replace("_", " ").replace("bool", "boolean") for each in ParameterType}
_LIST_SERVICE = "/list_parameters"


async def _find_node(tool: ToolNode, node: str) -> None:
    """Wait for a node that has parameters. Raises UnknownNameError."""
    view = await tool.snapshot_when(lambda seen: node in _nodes_with_parameters(seen))
    if node in _nodes_with_parameters(view):
        return
    if node in view.nodes:
        raise UnknownNameError(
            f"node {node} does not give access to its parameters; `rostether param list` shows which do"
        )
    hint = did_you_mean(node, view.nodes) or "`rostether node list` shows all nodes"
    raise UnknownNameError(f"Node not found: {node}; {hint}")


def _nodes_with_parameters(view: GraphView) -> list[str]:
    services = view.services(with_hidden=True)
    return [name.removesuffix(_LIST_SERVICE) for name in services if name.endswith(_LIST_SERVICE)]


async def _asked_of(graph: GraphOptions, node: str, question: Callable[[ParameterClient], Awaitable[T]]) -> T:
    from rostether.ros2.parameters.client import ParameterClient

    async def ask(tool: ToolNode) -> T:
        await _find_node(tool, node)
        return await question(ParameterClient(tool.graph.raw))

    return await asked(graph, ask)


async def _located(graph: GraphOptions, name: str, parameter: str | None) -> tuple[str, str]:
    """Return the node and the parameter that are given as two words or one. Raises UnknownNameError."""
    if parameter is not None:
        return full_node_name(name), parameter
    full_name = full_node_name(name)

    def owner(view: GraphView) -> str:
        above = [node for node in _nodes_with_parameters(view) if full_name.startswith(f"{node}/")]
        return max(above, key=len, default="")

    node = owner(await asked(graph, lambda tool: tool.snapshot_when(lambda view: bool(owner(view)))))
    if not node:
        raise UnknownNameError(f"no node has a parameter {full_name}; give NODE NAME, e.g. /board gain")
    return node, ".".join(name_parts(full_name[len(node) :]))


class Ros2Params:
    """The parameters of a ROS 2 graph; each method is a whole command."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph

    async def list_params(self, wanted: ParamListing) -> None:
        """Print the names of the parameters of one node, or of all nodes."""
        from rostether.ros2.parameters.client import ParameterClient

        node = None if wanted.namespace == "/" else wanted.namespace

        async def ask(tool: ToolNode) -> dict[str, dict[str, str]]:
            if node is not None:
                await _find_node(tool, full_node_name(node))
                nodes = [full_node_name(node)]
            else:
                nodes = _nodes_with_parameters(await tool.settled_snapshot())
                nodes = [each for each in nodes if wanted.with_hidden or not is_hidden(each)]
            client = ParameterClient(tool.graph.raw)
            found: dict[str, dict[str, str]] = {}
            for each in nodes:
                try:
                    names = sorted(await client.names(each))
                    names = [name for name in names if _is_below(name, wanted.prefixes)]
                    types = await _types(client, each, names) if wanted.with_types else {}
                except (GraphError, SerializationError) as error:
                    warn(f"Exception while calling service of node '{each}': {error}")
                    continue
                found[each] = {name: types.get(name, "") for name in names}
            return found

        for owner, names in (await asked(self._graph, ask)).items():
            if node is None and not wanted.as_json:
                write_line(escape_line(f"{owner}:"))
            for name, kind in names.items():
                record, shown = {"node": owner, "name": name}, f"  {name}"
                if wanted.with_types:
                    record, shown = {**record, "type": kind}, f"{shown} (type: {kind})"
                write_result(record, escape_line(shown), as_json=wanted.as_json)

    async def get(self, name: str, parameter: str | None, options: GetOptions) -> None:
        """Print a parameter with its type. Raises UnknownNameError."""
        refuse_ros1_only(pretty=options.pretty, verbose=options.verbose)
        node, path = await _located(self._graph, name, parameter)

        async def ask(client: ParameterClient) -> TypedValue:
            found = (await client.get(node, [path])).get(path, NOT_SET)
            if found != NOT_SET:
                return found
            names = await client.names(node)
            if path in names:
                raise UnknownNameError(
                    f"Parameter not set: node {node} has declared {path} without a value; "
                    "set it with `rostether param set`"
                )
            hint = did_you_mean(path, names) or f"`rostether param list {node}` shows its parameters"
            raise UnknownNameError(f"Parameter not set: node {node} has no parameter {path}; {hint}")

        value = await _asked_of(self._graph, node, ask)
        if options.as_json:
            from rostether.serde.plain_form import base64_text, plain_value

            write_json({"node": node, "name": path, "value": plain_value(value.value, base64_text)})
        elif options.hide_type:
            write_line(_shown(value))
        else:
            word = _TYPE_WORDS[value.type].removesuffix(" array").capitalize()
            write_line(
                f"{word} value{'s are' if isinstance(value.value, list | bytes) else ' is'}: {_shown(value)}"
            )

    async def set_param(self, words: tuple[str, ...], options: SetOptions) -> None:
        """Set the parameters of NODE NAME VALUE [NAME VALUE]..., or of one full name and its value."""
        refuse_ros1_only(textfile=options.textfile, binfile=options.binfile, verbose=options.verbose)
        if len(words) == 2:
            node, path = await _located(self._graph, words[0], None)
            pairs = [(path, words[1])]
        elif len(words) % 2:
            node, pairs = full_node_name(words[0]), list(zip(words[1::2], words[2::2], strict=True))
        else:
            raise click.UsageError("give NODE NAME VALUE; more pairs of NAME VALUE may follow")
        values = {name: parse_value(name, text) for name, text in pairs}
        for name, value in values.items():
            await _set(self._graph, node, {name: value}, "Setting")
            done = "Set parameter successful"
            write_line(escape_line(f"{name}: {done}") if len(values) > 1 else done)

    async def delete(self, name: str, parameter: str | None, *, verbose: bool) -> None:
        """Delete a parameter. Raises GraphError with the node's reason."""
        refuse_ros1_only(verbose=verbose)
        node, path = await _located(self._graph, name, parameter)
        await _set(self._graph, node, {path: NOT_SET}, "Deleting")
        write_line("Deleted parameter successfully")

    async def describe(self, node: str, names: tuple[str, ...], *, as_json: bool) -> None:
        """Print a node's descriptions of its parameters."""
        from rostether.serde.plain_form import to_plain

        owner = full_node_name(node)
        for each in await _asked_of(self._graph, owner, lambda client: client.describe(owner, names)):
            if as_json:
                write_json({"node": owner, **to_plain(each)})
                continue
            kind = _TYPE_WORDS.get(each.type, _TYPE_WORDS[NOT_SET.type])
            lines = [f"Parameter name: {each.name}", f"  Type: {kind}"]
            if each.description:
                lines.append(f"  Description: {each.description}")
            lines.append("  Constraints:")
            if each.read_only:
                lines.append("    Read only: true")
            for limits in [*each.floating_point_range, *each.integer_range][:1]:
                lines += [f"    Min value: {limits.from_value}", f"    Max value: {limits.to_value}"]
                lines += [f"    Step: {limits.step}"] if limits.step else []
            if each.additional_constraints:
                lines.append(f"    Additional constraints: {each.additional_constraints}")
            write_line("\n".join(map(escape_line, lines)))

    async def dump(self, node: Path | None, namespace: str, /, *, verbose: bool) -> None:
        """Print all parameters of a node as a file for `--params-file` and `param load`."""
        import yaml

        refuse_ros1_only(namespace=namespace, verbose=verbose)
        if node is None:
            raise click.UsageError("give a node, for example /board")
        owner = full_node_name(str(node))

        async def ask(client: ParameterClient) -> dict[str, TypedValue]:
            names = await client.names(owner)
            return await client.get(owner, sorted(names)) if names else {}

        tree: dict[str, Any] = {}
        for name, value in (await _asked_of(self._graph, owner, ask)).items():
            branch, key = tree, name
            while "." in key:
                part, _, below = key.partition(".")
                space = branch.setdefault(part, {})
                if not isinstance(space, dict):
                    # A node may have both `a` and `a.b`: the key keeps its dot.
                    break
                branch, key = space, below
            branch[key] = list(value.value) if isinstance(value.value, bytes) else value.value
        write_line(yaml.safe_dump({owner: {"ros__parameters": tree}}, default_flow_style=False))

    async def load(self, node: Path, file: str, /, *, verbose: bool) -> None:
        """Set the parameters that a file has for a node. Raises ConfigError, GraphError."""
        from rostether.ros2.parameters.parameter_file import read_parameter_files

        refuse_ros1_only(verbose=verbose)
        if not file:
            raise click.UsageError("give NODE FILE")
        owner = full_node_name(str(node))
        values = read_parameter_files([Path(file)]).for_node(owner)
        if not values:
            raise ConfigError(
                f"{file} has no parameters for {owner}; write them below {owner}: ros__parameters:"
            )

        async def ask(client: ParameterClient) -> int:
            failed = 0
            for name, value in values.items():
                try:
                    await client.set(owner, {name: typed_value(name, value)})
                    write_line(escape_line(f"Set parameter {name} successful"))
                except (GraphError, SerializationError) as error:
                    failed += 1
                    warn(escape_line(f"Set parameter {name} failed: {error}"))
            return failed

        if failed := await _asked_of(self._graph, owner, ask):
            raise GraphError(f"{failed} of {len(values)} parameters could not be set")


async def _types(client: ParameterClient, node: str, names: list[str]) -> dict[str, str]:
    # Descriptions lack some types: rclpy describes no parameter that was never declared.
    values = await client.get(node, names) if names else {}
    return {name: _TYPE_WORDS[values.get(name, NOT_SET).type] for name in names}


def _is_below(name: str, prefixes: Sequence[str]) -> bool:
    return not prefixes or any(name == each or name.startswith(f"{each}.") for each in prefixes)


def _shown(value: TypedValue) -> str:
    """Return a value as `ros2 param` prints it."""
    if isinstance(value.value, bytes):
        return str([bytes([byte]) for byte in value.value])
    codes = {ParameterType.INTEGER_ARRAY: "q", ParameterType.DOUBLE_ARRAY: "d"}
    if value.type in codes:
        numbers: Any = value.value
        return str(array(codes[value.type], numbers))
    return str(value.value)


def parse_value(name: str, text: str) -> TypedValue:
    """Return the value of a text as in `ros2 param set`: a string, unless YAML reads another value."""
    from rostether.bounded_yaml import YamlError, load
    from rostether.param_yaml import looks_like_number

    try:
        value = load(text)
        if looks_like_number(value):
            value = float(value)
        if isinstance(value, bool | int | float | list):
            return typed_value(name, value)
    except (YamlError, SerializationError):
        pass
    return typed_value(name, text)


async def _set(graph: GraphOptions, node: str, values: dict[str, TypedValue], verb: str) -> None:
    try:
        await _asked_of(graph, node, lambda client: client.set(node, values))
    except UnknownNameError:
        raise
    except GraphError as error:
        raise GraphError(f"{verb} parameter failed: {error}") from None
