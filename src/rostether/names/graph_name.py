"""The rules of ROS 1 graph names: `/global/name`, `relative/name`, `~private`.

Source: rosgraph.names (rospy) and ros::names (roscpp); where they differ, the stricter one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from rostether.errors import InvalidNameError

SEPARATOR = "/"
PRIVATE = "~"

_LEGAL = re.compile(r"[~/A-Za-z][A-Za-z0-9_/]*")
_ILLEGAL_CHARACTER = re.compile(r"[^A-Za-z0-9_/]")

# A board can announce any bytes as a name; the error must be one readable line.
_MAX_QUOTED_CHARACTERS = 80

# The last part of the names of services that every node offers about itself, in ROS 1 or in ROS 2.
NODE_SERVICES = frozenset(
    {"get_loggers", "set_logger_level", "describe_parameters", "get_parameter_types", "get_parameters"}
    | {"list_parameters", "set_parameters", "set_parameters_atomically", "get_type_description"}
)

NO_REMAPPINGS: Mapping[str, str] = MappingProxyType({})


def is_global(name: str) -> bool:
    """Return whether the name starts at the root, as `/a`."""
    return name.startswith(SEPARATOR)


def is_private(name: str) -> bool:
    """Return whether the name belongs to a node, as `~a`."""
    return name.startswith(PRIVATE)


def is_legal_name(name: str) -> bool:
    """Return whether ROS accepts the name; the empty name is legal and means the namespace."""
    return not name or (_LEGAL.fullmatch(name) is not None and "//" not in name)


def validate_name(name: str) -> str:
    """Return the name unchanged. Raises InvalidNameError for an illegal or empty one, with the reason."""
    if name and is_legal_name(name):
        return name
    raise InvalidNameError(f"{quote(name)} is not a ROS name: {_reason(name)}")


def join(namespace: str, name: str) -> str:
    """Put a relative name into a namespace (`/`, `/ns`, `~` or empty); other names are returned unchanged."""
    if is_global(name) or is_private(name) or not namespace:
        return name
    if namespace == PRIVATE or namespace.endswith(SEPARATOR):
        return namespace + name
    return namespace + SEPARATOR + name


def namespace_of(name: str) -> str:
    """Return the namespace of the name, without a trailing slash: `/a/b` -> `/a`, `/b` -> `/`."""
    return name.removesuffix(SEPARATOR).rpartition(SEPARATOR)[0] or SEPARATOR


def as_namespace(name: str) -> str:
    """Return a name as a global namespace with a trailing slash: `a/b` -> `/a/b/`, `/` -> `/`."""
    return canonical(SEPARATOR + name).removesuffix(SEPARATOR) + SEPARATOR


def canonical(name: str) -> str:
    """Return the name without doubled or trailing slashes; `/` is unchanged."""
    cleaned = SEPARATOR.join(part for part in name.split(SEPARATOR) if part)
    return SEPARATOR + cleaned if is_global(name) else cleaned


def _reason(name: str) -> str:
    if not name:
        return "it is empty"
    if not _LEGAL.match(name):
        return "it must start with a letter, '/' or '~'"
    if "//" in name:
        return "it has an empty part ('//')"
    found = _ILLEGAL_CHARACTER.search(name, 1)
    return f"{found.group()!r} is not a letter, digit, '_' or '/'" if found else "it is malformed"


def quote(text: str) -> str:
    """Return a text in quotes, cut to the length for an error line."""
    return repr(text if len(text) <= _MAX_QUOTED_CHARACTERS else text[:_MAX_QUOTED_CHARACTERS] + "...")


def resolve_name(
    name: str, *, namespace: str, node_name: str, remappings: Mapping[str, str] = NO_REMAPPINGS
) -> str:
    """Return the fully qualified, remapped name.

    `/a` is unchanged, `a` is put into `namespace`, `~a` into `node_name` (fully qualified), and the empty
    name is the namespace itself. `remappings` maps resolved names to resolved names (`resolve_remappings`),
    as in roscpp and rospy; a result is not remapped again. Raises InvalidNameError.
    """
    if not is_legal_name(name):
        # roscpp removes doubled slashes in a name; other illegal names have no meaning.
        validate_name(canonical(name) or name)
    if is_private(name):
        if not is_global(node_name):
            raise InvalidNameError(
                f"{quote(name)} is private to a node, and no node is known here; write the full name"
            )
        resolved = canonical(node_name + SEPARATOR + name[1:])
    elif is_global(name):
        resolved = canonical(name)
    else:
        resolved = canonical(SEPARATOR + namespace + SEPARATOR + name)
    return remappings.get(resolved, resolved)


def resolve_remappings(remappings: Mapping[str, str], *, namespace: str, node_name: str) -> dict[str, str]:
    """Resolve both sides of remappings as given on a command line. Raises InvalidNameError."""
    return {
        resolve_name(source, namespace=namespace, node_name=node_name): resolve_name(
            target, namespace=namespace, node_name=node_name
        )
        for source, target in remappings.items()
    }


def is_hidden(name: str) -> bool:
    """Return whether listings hide a name, as those of ROS 2 do: a part of it begins with `_`."""
    return any(part.startswith("_") for part in name.split("/"))


def is_in_namespace(name: str, namespace: str) -> bool:
    """Return whether a full name is a namespace or in it."""
    return name == namespace or name.startswith(namespace.rstrip("/") + "/")
