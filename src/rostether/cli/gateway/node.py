"""Gateway nodes: their names (two gateways of one graph are two nodes) and their parameters."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import click
from msgspec import Struct, field

from rostether.cli.gateway.options import DEFAULT_ADDRESS
from rostether.errors import ConfigError, GraphError, UnknownNameError
from rostether.names.graph_name import canonical, join, validate_name
from rostether.names.remap import parse_arguments
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node_queries import ping

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph

# Takes a node's full name and returns whether a node of that name answers. Raises GraphError.
IsLive: TypeAlias = Callable[[str], Awaitable[bool]]


_TRUE = ("true", "1", "yes", "on")
# The values in launch files for an unset parameter; Python nodes use "None".
_NOTHING = (None, "", "None")


class NodeNaming(Struct, frozen=True):
    """The name, namespace and remappings of a gateway's node; an empty name means the gateway's own."""

    name: str = ""
    namespace: str = "/"
    remappings: Mapping[str, str] = field(default_factory=dict)

    def name_for(self, own_name: str, port: int, default_port: int) -> str:
        """Return the name. It contains the port, unless this is the default port."""
        if self.name:
            return self.name
        # Port 0 is any free port, which is not known yet.
        return own_name if port in (0, default_port) else f"{own_name}_{port}"


def read_gateway_arguments(words: Sequence[str], special: Mapping[str, str]) -> tuple[str, NodeNaming]:
    """Return the address to listen on, [HOST:]PORT, and the naming of the node.

    Raises click.UsageError, ConfigError, InvalidNameError.
    """
    arguments = parse_arguments(words)
    if arguments.private_params:
        name = next(iter(arguments.private_params))
        raise click.UsageError(
            f"_{name}:= works only for the node in launch files; use the options and HOST:PORT here"
        )
    if len(arguments.rest) > 1:
        raise click.UsageError(f"give only one [HOST:]PORT, not {' and '.join(arguments.rest)}")
    name = special.get("__name", "")
    namespace = canonical("/" + special.get("__ns", ""))
    if name:
        validate_name(name)
    validate_name(namespace)
    address = arguments.rest[0] if arguments.rest else DEFAULT_ADDRESS
    return address, NodeNaming(name, namespace, arguments.remappings)


def ros1_liveness(environment: RosEnvironment) -> IsLive:
    """Return a function that checks whether a ROS 1 node is alive: the master also lists killed nodes."""

    async def is_live(name: str) -> bool:
        master = MasterClient(environment.master_uri, name)
        try:
            uri = await master.lookup_node(name)
        except UnknownNameError:
            return False
        finally:
            await master.close()
        try:
            await ping(name, uri)
        except GraphError:
            return False
        return True

    return is_live


async def check_free(name: str, namespace: str, is_live: IsLive | None) -> None:
    """Raise GraphError if a live node has the name: a second node would end it."""
    full_name = join(namespace, name)
    if is_live is not None and await is_live(full_name):
        raise GraphError(
            f"a node {full_name} is already running; stop it, or give this one another port or name "
            "(__name:=other)"
        )


async def private_parameters(graph: TypedGraph) -> dict[str, Any]:
    """Return all private parameters of the node; empty if it has none."""
    found = await graph.get_param("~", {})
    return dict(found) if isinstance(found, Mapping) else {}


def is_true(parameters: Mapping[str, Any], name: str) -> bool:
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
