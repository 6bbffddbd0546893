"""From a name as a program or a board writes it to the one name the graph knows."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from rostether.errors import InvalidNameError
from rostether.names.graph_name import (
    SEPARATOR,
    canonical,
    is_global,
    is_legal_name,
    is_private,
    validate_name,
)

NO_REMAPPINGS: Mapping[str, str] = MappingProxyType({})


def resolve_name(
    name: str, *, namespace: str, node_name: str, remappings: Mapping[str, str] = NO_REMAPPINGS
) -> str:
    """Return the fully qualified, remapped name.

    `/a` stays, `a` goes into `namespace`, `~a` into `node_name` (fully qualified), the empty name is the
    namespace itself. `remappings` maps resolved names to resolved names (`resolve_remappings`), as in roscpp
    and rospy; a result is not remapped again. Raises InvalidNameError.
    """
    if not is_legal_name(name):
        # roscpp forgives doubled slashes in a name and cleans them; anything else illegal has no meaning.
        validate_name(canonical(name) or name)
    if is_private(name):
        if not is_global(node_name):
            raise InvalidNameError(f"{name!r} is private to a node, and no node name is known here")
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
