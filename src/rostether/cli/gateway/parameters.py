"""Parameters of gateway nodes, as in launch files for the ROS originals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph

_TRUE = ("true", "1", "yes", "on")
# The values in launch files for an unset parameter; Python nodes use "None".
_NOTHING = (None, "", "None")


async def private_parameters(graph: TypedGraph) -> dict[str, Any]:
    """Return all private parameters of the node; empty if it has none."""
    found = await graph.raw.get_param("~") if await graph.raw.has_param("~") else {}
    return dict(found) if isinstance(found, Mapping) else {}


def flag(parameters: Mapping[str, Any], name: str) -> bool:
    """Return a parameter that is true or false, False if it is missing."""
    return str(parameters.get(name, False)).strip().lower() in _TRUE


def whole_number(parameters: Mapping[str, Any], name: str, default: int) -> int:
    """Return a number that is not negative. Raises ConfigError naming the parameter."""
    value = parameters.get(name)
    if value in _NOTHING:
        return default
    try:
        number = int(str(value).strip())
    except ValueError:
        number = -1
    if isinstance(value, bool) or number < 0:
        raise ConfigError(f"~{name} must be a whole number, not {value!r}")
    return number


def certificate_files(parameters: Mapping[str, Any], switch: str) -> tuple[str, str]:
    """Return ~certfile and ~keyfile. Raises ConfigError naming the switch that needs them."""
    if not parameters.get("certfile"):
        raise ConfigError(f"~{switch} needs ~certfile and ~keyfile: a certificate and its key")
    return str(parameters["certfile"]), str(parameters.get("keyfile") or "")
