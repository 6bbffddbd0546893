"""What the parameter commands share: names that need not be legal ones, and unknown names."""

from __future__ import annotations

from rostether.cli.access.ros1_access import resolve
from rostether.errors import InvalidNameError, UnknownNameError
from rostether.names.graph_name import SEPARATOR, canonical, is_global
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient


def param_name(name: str, environment: RosEnvironment) -> str:
    """Return the full name of a parameter.

    Keys of YAML files often break the rules of names, as `max-speed` does. Masters keep them all the same,
    so they can be read and deleted.
    """
    try:
        return resolve(name, environment)
    except InvalidNameError:
        return canonical(name if is_global(name) else environment.namespace + SEPARATOR + name)


async def not_set(client: MasterClient, name: str) -> UnknownNameError:
    """Return the error for a parameter that is not set, with the nearest one that is."""
    from difflib import get_close_matches

    near = get_close_matches(name, _with_namespaces(await client.param_names()), n=1)
    hint = f"did you mean {near[0]}?" if near else "`rostether param list` shows the set ones"
    return UnknownNameError(f"parameter {name} is not set; {hint}")


def _with_namespaces(names: list[str]) -> set[str]:
    found = set(names)
    for name in names:
        while name := name.rpartition(SEPARATOR)[0]:
            found.add(name)
    return found
