"""The names of a rospy program: its command line remaps them; they resolve before and after init_node."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Mapping
from typing import Any

from rostether.bounded_yaml import YamlError, load
from rostether.names.graph_name import as_namespace, canonical, is_global, is_private
from rostether.rospy.client.exceptions import ROSException, ROSInitException

# The name of a program until init_node.
UNNAMED = "unnamed"

_REMAP = re.compile(r"([~/A-Za-z_][\w/]*):=(.*)", re.DOTALL)


class NodeNames:
    """The name, namespace and remappings of a program; a process has one."""

    def __init__(self, argv: Iterable[str], environ: Mapping[str, str]) -> None:
        self.mappings: dict[str, str] = {}
        self.resolved_mappings: dict[str, str] = {}
        self.private_params: dict[str, Any] = {}
        self.load(argv)
        self.namespace = as_namespace(self.mappings.get("__ns") or environ.get("ROS_NAMESPACE") or "/")
        self.caller_id = self.namespace + UNNAMED

    def load(self, argv: Iterable[str]) -> None:
        """Read the remappings of a command line. Raises ROSInitException for a value that is not YAML."""
        self.mappings = {}
        self.private_params = {}
        for argument in argv:
            if (match := _REMAP.fullmatch(argument)) is None:
                continue
            source, target = match[1], match[2].strip()
            if not target:
                continue
            if source.startswith("_") and not source.startswith("__") and len(source) > 1:
                self.private_params[source[1:]] = _yaml(argument, target)
            else:
                self.mappings[source] = target

    def set_node_name(self, base_name: str) -> str:
        """Set the node's name, with which private names resolve. Returns its full name."""
        self.caller_id = full_name(base_name, self.caller_id)
        self.namespace = parent_namespace(self.caller_id)
        self.resolved_mappings = {}
        for source, target in self.mappings.items():
            if source.startswith("__"):
                self.resolved_mappings[source] = target
            else:
                self.resolved_mappings[full_name(source, self.caller_id)] = full_name(target, self.caller_id)
        return self.caller_id

    def resolve(self, name: str, caller_id: str | None = None) -> str:
        """Return the full name after remapping, as in the node `caller_id` (default: this node)."""
        caller_id = caller_id or self.caller_id
        if not name:
            return parent_namespace(caller_id)
        resolved = full_name(str(name), caller_id)
        return self.resolved_mappings.get(resolved, resolved)

    def resolve_early(self, name: str) -> str:
        """Return the full name of a topic or service that is created before init_node.

        Raises ValueError for a private name, ROSInitException if it is remapped to one.
        """
        if is_private(name):
            raise ValueError("~name topics cannot be created before init_node() has been called")
        fake_caller = self.namespace + "node"
        resolved = full_name(name, fake_caller)
        for source, target in self.mappings.items():
            if not source.startswith("__") and full_name(source, fake_caller) == resolved:
                if is_private(target):
                    raise ROSInitException(
                        f"{name} cannot be remapped to a ~name here: the topic is created before init_node()"
                    )
                return full_name(target, fake_caller)
        return resolved

    def remap(self, name: str) -> str:
        """Return the resolved target of a name that the command line remaps, else the same name."""
        return full_name(self.mappings[name], self.caller_id) if name in self.mappings else name


def full_name(name: str, caller_id: str) -> str:
    """Return the full name, as in the node `caller_id`, without remapping.

    Like rospy, this accepts illegal names; the graph rejects them.
    """
    if is_private(name):
        return canonical(f"{caller_id}/{name[1:]}")
    return canonical(name if is_global(name) else f"/{parent_namespace(caller_id)}{name}")


def is_remap_argument(argument: str) -> bool:
    """Return whether an argument belongs to ROS: a remapping, a parameter or a special name."""
    return _REMAP.fullmatch(argument) is not None


def parent_namespace(full_name: str) -> str:
    """Return the namespace of a full name, with a slash at the end."""
    return full_name[: full_name.removesuffix("/").rfind("/") + 1] or "/"


def _yaml(argument: str, text: str) -> Any:
    try:
        return load(text)
    except YamlError as error:
        raise ROSInitException(f"invalid command-line parameter {argument!r}: this is {error}") from None


names = NodeNames(sys.argv, os.environ)


def get_name() -> str:
    """Return the node's full name."""
    return names.caller_id


get_caller_id = get_name


def get_namespace() -> str:
    """Return the node's namespace, with a slash at the end."""
    return names.namespace


def resolve_name(name: str, caller_id: str | None = None) -> str:
    """Return the full name after remapping."""
    return names.resolve(name, caller_id)


def resolve_name_without_node_name(name: str) -> str:
    """Return the full name of a name that is used before init_node. Raises ValueError, ROSInitException."""
    return names.resolve_early(name)


def remap_name(name: str, caller_id: str | None = None, resolved: bool = True) -> str:
    """Return the remapped name, or the name itself."""
    return names.remap(name)


def get_mappings() -> dict[str, str]:
    """Return the remappings as written on the command line."""
    return names.mappings


def get_resolved_mappings() -> dict[str, str]:
    """Return the remappings between full names."""
    return names.resolved_mappings


def get_ros_root(required: bool = False, env: Mapping[str, str] | None = None) -> str | None:
    """Return ROS_ROOT. Raises ROSException if it is `required` but not set."""
    root = (os.environ if env is None else env).get("ROS_ROOT")
    if required and not root:
        raise ROSException("ROS_ROOT is not set")
    return root
