"""The names of ROS 2: types as in DDS and zenoh, and loggers; rules for nodes, namespaces and topics.

Source: rmw's validate_full_topic_name, validate_namespace and validate_node_name.
"""

from __future__ import annotations

import re

from rostether.errors import InvalidNameError
from rostether.names.graph_name import quote

# rmw's limit.
MAX_NODE_NAME_CHARACTERS = 255

# rmw's limit, which leaves room for the node's name and DDS's prefix.
MAX_NAMESPACE_CHARACTERS = 245

# rmw's limit: a DDS topic has 255 characters, including a prefix of 8.
MAX_TOPIC_NAME_CHARACTERS = 247

_DDS_NAME = re.compile(r"([A-Za-z]\w*)::(msg|srv|action)::dds_::([A-Za-z]\w*)_", re.ASCII)
_ILLEGAL_CHARACTER = re.compile(r"[^A-Za-z0-9_/]")


def dds_name(name: str) -> str:
    """Return a type's name in the middlewares: `std_msgs/msg/String` -> `std_msgs::msg::dds_::String_`."""
    package, kind, short_name = name.split("/")
    return f"{package}::{kind}::dds_::{short_name}_"


def type_of_dds_name(name: str) -> str:
    """Return the type with this name in the middleware, or an empty string: peers may send invalid names."""
    found = _DDS_NAME.fullmatch(name)
    return "/".join(found.groups()) if found else ""


def logger_name(node_name: str) -> str:
    """Return the name of a node's logger as in rcl: `/lab/board` logs as `lab.board`."""
    return node_name.strip("/").replace("/", ".")


def validate_node_name(name: str) -> str:
    """Return a node's full name, `/ns/node`, with a leading slash. Raises InvalidNameError with a reason."""
    full_name = name if name.startswith("/") else f"/{name}"
    namespace, _, node = full_name.rpartition("/")
    if not node:
        raise InvalidNameError(f"{quote(name)} is not a ROS 2 node name: it is empty after the last '/'")
    if len(node) > MAX_NODE_NAME_CHARACTERS:
        raise InvalidNameError(
            f"{quote(name)} is not a ROS 2 node name: longer than {MAX_NODE_NAME_CHARACTERS} characters"
        )
    _validate(full_name, name, "node name", None)
    validate_namespace(namespace or "/")
    return full_name


def validate_namespace(name: str) -> str:
    """Return a namespace, `/` or `/a/b`, unchanged. Raises InvalidNameError with the reason."""
    if name != "/":
        _validate(name, name, "namespace", MAX_NAMESPACE_CHARACTERS)
    return name


def validate_topic_name(name: str) -> str:
    """Return the full name of a topic or service unchanged. Raises InvalidNameError with the reason."""
    _validate(name, name, "topic or service name", MAX_TOPIC_NAME_CHARACTERS)
    return name


def _validate(full_name: str, shown: str, noun: str, limit: int | None) -> None:
    reason = _reason(full_name, limit)
    if reason:
        raise InvalidNameError(f"{quote(shown)} is not a ROS 2 {noun}: {reason}")


def _reason(name: str, limit: int | None) -> str:
    if limit is not None and len(name) > limit:
        return f"longer than {limit} characters"
    if found := _ILLEGAL_CHARACTER.search(name):
        return f"{found[0]!r} is not allowed, only letters, digits, '_' and '/'"
    if not name.startswith("/"):
        return "a full name starts with '/'"
    if name.endswith("/"):
        return "it ends with '/'"
    for part in name[1:].split("/"):
        if not part:
            return "'//' is not allowed"
        if part[0].isdigit():
            return f"{quote(part)} starts with a digit"
    return ""
