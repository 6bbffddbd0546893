"""Names of parameters: `/ns/node/a/b` in the graph port is `a.b` of the node `/ns/node` in ROS 2."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from rostether.names.graph_name import is_in_namespace, namespace_of

DOT = "."

_PARTS = re.compile(r"[./]+")


class ParameterPath(NamedTuple):
    """A parameter of a node, with all parameters below it; the empty path means all its parameters."""

    node: str
    path: str

    def holds(self, name: str) -> bool:
        """Return whether a parameter is at this path or below it."""
        parts = name_parts(self.path)
        return name_parts(name)[: len(parts)] == parts


def locate(full_name: str, nodes: Iterable[str], own_node: str) -> ParameterPath:
    """Return the owner of a parameter: the node with the longest name above the parameter's full name.

    A name that is not below any node is a parameter of `own_node`.
    """
    above = [node for node in (*nodes, own_node) if is_in_namespace(full_name, node)]
    if above:
        node = max(above, key=len)
        return ParameterPath(node, _dotted(full_name[len(node) :]))
    inside = full_name.removeprefix(namespace_of(own_node).rstrip("/") + "/")
    return ParameterPath(own_node, _dotted(inside))


def full_name(node: str, name: str) -> str:
    """Return the full name of a node's parameter."""
    return "/".join((node, *name_parts(name)))


def name_parts(name: str) -> list[str]:
    """Return the parts of a parameter's name, `a.b` as well as `a/b`."""
    return [part for part in _PARTS.split(name) if part]


def _dotted(name: str) -> str:
    return DOT.join(name_parts(name))
