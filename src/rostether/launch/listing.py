"""The lists that `rostether launch` prints instead of starting nodes, and the summary before a start."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path

from rostether.errors import ConfigError
from rostether.graph.ports import ParamValue
from rostether.launch.command_line import Locate, Replaced, command_of
from rostether.launch.plan import LaunchNode, LaunchPlan
from rostether.names.graph_name import join

# As in roslaunch: the summary shows only the start of a long value, such as a URDF.
_MAX_VALUE_CHARS = 20


def node_lines(plan: LaunchPlan) -> list[str]:
    """Return the full names of the nodes."""
    return [node.full_name for node in plan.nodes]


def argument_lines(plan: LaunchPlan) -> Iterator[str]:
    """Yield the arguments of the files, required ones first."""
    known = [plan.arguments[name] for name in sorted(plan.arguments) if not plan.arguments[name].is_fixed]
    required = [each for each in known if not each.default]
    optional = [each for each in known if each.default]
    if not known:
        yield "No arguments."
    if required:
        yield "Required Arguments:"
    for each in required:
        yield f"  {each.name}: {each.doc or 'undocumented'}"
    if optional:
        yield "Optional Arguments:"
    for each in optional:
        yield f'  {each.name} (default "{each.default}"): {each.doc or "undocumented"}'


def file_lines(plan: LaunchPlan) -> list[str]:
    """Return the absolute paths of all files that were read."""
    return [str(Path(file).absolute()) for file in plan.files]


def find_node(plan: LaunchPlan, name: str, namespace: str) -> LaunchNode:
    """Return the first node with a name: its name without namespace, or in `namespace` if it is relative.

    Raises ConfigError if there is none.
    """
    full_name = join(namespace, name)
    for node in plan.nodes:
        if full_name == node.full_name or name == node.name:
            return node
    names = ", ".join(node_lines(plan)) or "none"
    raise ConfigError(f"there is no node {name} in these files; the nodes are {names}")


def shell_line(node: LaunchNode, environ: Mapping[str, str], master_uri: str, locate: Locate) -> str:
    """Return the shell line that starts a node: its changes to the environment, and the command.

    Raises RostetherError if there is no such program.
    """
    command = command_of(node, environ, master_uri, locate)
    if isinstance(command, Replaced):
        raise ConfigError(command.line)
    differing = [
        f"{name}={shlex.quote(value)}"
        for name, value in command.environ.items()
        if os.environ.get(name) != value
    ]
    return " ".join([*differing, shlex.join(command.words)])


def summary_lines(plan: LaunchPlan) -> Iterator[str]:
    """Yield the summary of the launch, as roslaunch prints it."""
    yield from ("", "SUMMARY", "========", "")
    if plan.cleared:
        yield "CLEAR PARAMETERS"
        yield from sorted(f" * {name}" for name in plan.cleared)
        yield ""
    if plan.parameters:
        yield "PARAMETERS"
        yield from sorted(f" * {name}: {_short(value)}" for name, value in plan.parameters.items())
        yield ""
    yield "NODES"
    for namespace in sorted({node.namespace for node in plan.nodes}):
        yield f"  {namespace.rstrip('/')}/"
        yield from sorted(
            f"    {node.name} ({node.package}/{node.type})"
            for node in plan.nodes
            if node.namespace == namespace
        )
    yield ""


def _short(value: ParamValue) -> str:
    text = str(value).strip()
    if len(text) > _MAX_VALUE_CHARS:
        text = text[: _MAX_VALUE_CHARS - 3] + "..."
    return text if text.isprintable() else "<...>"
