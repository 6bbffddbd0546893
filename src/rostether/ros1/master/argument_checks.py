"""Checks the arguments of the Master API, with the error texts of rosmaster.

A check gets (value, caller id) and returns the value to use, with resolved names; it raises BadArgumentError.
As in rosmaster, a name may have characters that the naming rules do not allow: old nodes have such names and
must not be refused.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from rostether.names.graph_name import canonical
from rostether.ros1.master.registrations import ANY_TYPE
from rostether.xmlrpc.values import XmlRpcValue

Check: TypeAlias = Callable[[XmlRpcValue, str], XmlRpcValue]

# Far longer than any name in practice; without a limit, a node could fill the tables with a few
# registrations.
MAX_NAME_LENGTH = 2048


class BadArgumentError(ValueError):
    """An argument that the API refuses; the caller gets the text."""


def resolve(name: str, caller_id: str) -> str:
    """Return a global name: `~x` is below the caller, `x` beside it; an empty name is its namespace."""
    if not name:
        return _namespace(caller_id)
    if name.startswith("/"):
        return canonical(name)
    if name.startswith("~"):
        return canonical(f"{caller_id}/{name[1:]}")
    return _namespace(caller_id) + canonical(name)


def _namespace(name: str) -> str:
    return name.removesuffix("/").rpartition("/")[0] + "/"


def _text(label: str, value: XmlRpcValue) -> str:
    if not isinstance(value, str) or not value:
        raise BadArgumentError(f"ERROR: parameter [{label}] must be a non-empty string")
    if len(value) > MAX_NAME_LENGTH:
        raise BadArgumentError(f"ERROR: parameter [{label}] is longer than {MAX_NAME_LENGTH} characters")
    if not value.isprintable():
        # Such a name could control the terminal of a user who lists it, and fake lines of a log.
        raise BadArgumentError(f"ERROR: parameter [{label}] contains illegal chars")
    return value


def any_value(value: XmlRpcValue, _caller_id: str) -> XmlRpcValue:
    """Accept everything."""
    return value


def some_value(value: XmlRpcValue, _caller_id: str) -> XmlRpcValue:
    """Accept everything except nil."""
    if value is None:
        raise BadArgumentError("ERROR: parameter [value] must be specified")
    return value


def param_key(value: XmlRpcValue, _caller_id: str) -> str:
    """Accept a parameter's name unchanged; each method resolves it, or searches for it."""
    if not value:
        raise BadArgumentError("ERROR: parameter [key] must be specified and non-empty")
    if not isinstance(value, str) or len(value) > MAX_NAME_LENGTH:
        raise BadArgumentError(
            f"ERROR: parameter [key] must be a string of at most {MAX_NAME_LENGTH} characters"
        )
    if not value.isprintable():
        raise BadArgumentError("ERROR: parameter [key] contains illegal chars")
    return value


def name_of(label: str, *, may_be_root: bool = True) -> Check:
    """Return a check of a name, which it resolves."""

    def check(value: XmlRpcValue, caller_id: str) -> str:
        name = _text(label, value)
        if ":" in name or " " in name:
            raise BadArgumentError(f"ERROR: parameter [{label}] contains illegal chars")
        resolved = resolve(name, caller_id)
        if resolved == "/" and not may_be_root:
            raise BadArgumentError(f"ERROR: parameter [{label}] cannot be the global namespace")
        return resolved

    return check


def subgraph(value: XmlRpcValue, caller_id: str) -> str:
    """Check a namespace; the empty one stays empty and means the whole graph."""
    if not isinstance(value, str):
        raise BadArgumentError("ERROR: parameter [subgraph] must be a string")
    return resolve(value, caller_id) if value else ""


def topic_type(value: XmlRpcValue, _caller_id: str) -> str:
    """Check the name of a message type, or `*`."""
    if value == ANY_TYPE:
        return ANY_TYPE
    name = _text("topic_type", value)
    if name.count("/") != 1:
        raise BadArgumentError("ERROR: parameter [topic_type] is not a valid package resource name")
    return name


def api_of(label: str) -> Check:
    """Return a check of a node's or service's URI."""

    def check(value: XmlRpcValue, _caller_id: str) -> str:
        if not isinstance(value, str) or not value or len(value) > MAX_NAME_LENGTH:
            raise BadArgumentError(f"ERROR: parameter [{label}] is not an XMLRPC URI")
        if not value.startswith(("http://", "rosrpc://")) or not value.isprintable():
            raise BadArgumentError(f"ERROR: parameter [{label}] is not an RPC URI")
        return value

    return check
