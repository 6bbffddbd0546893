"""rosgraph.names: joins, resolves and checks names."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Mapping
from typing import Any

from rostether.mechanisms.anonymous import anonymous_name as anonymous_name
from rostether.names.graph_name import canonical, is_global, is_private, join
from rostether.names.graph_name import is_legal_name as _is_legal
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.names import NodeNames, is_remap_argument, parent_namespace

SEP = "/"
GLOBALNS = "/"
PRIV_NAME = "~"
REMAP = ":="
ANYTYPE = TOPIC_ANYTYPE = SERVICE_ANYTYPE = "*"

_BASE_NAME = re.compile(r"[A-Za-z]\w*")


def namespace(name: str) -> str:
    """Return the namespace of a name, with a slash at the end.

    Raises ValueError for None, TypeError for any other value that is not text.
    """
    if name is None:
        raise ValueError("name")
    if not isinstance(name, str):
        raise TypeError("name")
    return parent_namespace(name)


def ns_join(ns: str, name: str) -> str:
    """Put a relative name into a namespace; return other names unchanged."""
    return join(ns, name)


def make_global_ns(name: str) -> str:
    """Return a name as a namespace: `/name/`. Raises ValueError for private names."""
    if is_private(name):
        raise ValueError(f"cannot turn [{name}] into a global name")
    return f"{name if is_global(name) else SEP + name}".removesuffix(SEP) + SEP


def get_ros_namespace(env: Mapping[str, str] | None = None, argv: Iterable[str] | None = None) -> str:
    """Return the namespace of the command line, else of ROS_NAMESPACE, with a slash at the end."""
    for argument in sys.argv if argv is None else argv:
        if argument.startswith("__ns:="):
            return make_global_ns(argument.removeprefix("__ns:="))
    return make_global_ns((os.environ if env is None else env).get("ROS_NAMESPACE", GLOBALNS))


def make_caller_id(name: str) -> str:
    """Return the full name of a program on the graph, with a slash at the end."""
    return make_global_ns(ns_join(get_ros_namespace(), name))


def load_mappings(argv: Iterable[str]) -> dict[str, str]:
    """Return the remappings of a command line, without private parameters."""
    return NodeNames(argv, {}).mappings


def is_legal_name(name: str | None) -> bool:
    """Return whether ROS accepts a name."""
    return name is not None and _is_legal(name)


def is_legal_base_name(name: str | None) -> bool:
    """Return whether ROS accepts a name without a namespace."""
    return name is not None and _BASE_NAME.fullmatch(name) is not None


def is_legal_remap(arg: str | None) -> bool:
    """Return whether an argument is a remapping."""
    return arg is not None and is_remap_argument(arg)


def canonicalize_name(name: str) -> str:
    """Return a name without doubled or trailing slashes."""
    return canonical(name) if name else name


def resolve_name(name: str, namespace_: str, remappings: Mapping[str, str] | None = None) -> str:
    """Return the full name after remapping, as in the node `namespace_`."""
    if not name:
        return namespace(namespace_)
    name = canonical(name)
    if is_private(name):
        name = canonical(f"{namespace_}{SEP}{name[1:]}")
    elif not is_global(name):
        name = namespace(namespace_) + name
    return (remappings or {}).get(name, name)


def script_resolve_name(script_name: str, name: str) -> str:
    """Return the full name, as in a program without a node."""
    if not name:
        return get_ros_namespace()
    if is_private(name):
        return ns_join(make_caller_id(script_name), name[1:])
    return name if is_global(name) else get_ros_namespace() + name


def scoped_name(caller_id: str, name: str) -> str:
    """Return a full name relative to a node's namespace. Raises ROSException for a relative node name."""
    if not is_global(caller_id):
        raise ROSException("caller_id must be global")
    return canonicalize_name(name)[len(namespace(caller_id)) :]


def isstring(s: Any) -> bool:
    """Return whether a value is text."""
    return isinstance(s, str)


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return a command line without remappings."""
    return [argument for argument in (sys.argv if argv is None else argv) if REMAP not in argument]
