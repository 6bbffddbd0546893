"""Parameters of the robot nodes: the private one first, then the one in the nearest namespace."""

from __future__ import annotations

from collections.abc import Mapping

from rostether.errors import ConfigError
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.robot.robot_model import RobotModel
from rostether.robot.urdf import parse_urdf

DESCRIPTION = "robot_description"


async def read_model(graph: TypedGraph) -> RobotModel:
    """Return the robot in robot_description. Raises ConfigError if the parameter is missing,
    RobotModelError.
    """
    name = f"~{DESCRIPTION}"
    if not await graph.has_param(name):
        found = await graph.search_param(DESCRIPTION)
        remapped = graph.resolve(DESCRIPTION)
        name = remapped if await graph.has_param(remapped) else found or ""
    text = await graph.get_param(name) if name else None
    if not isinstance(text, str | bytes):
        raise ConfigError(
            f"the parameter {DESCRIPTION} has no URDF; set it in a launch file: "
            f'<param name="{DESCRIPTION}" textfile="ROBOT.urdf"/>'
        )
    return parse_urdf(text, file=DESCRIPTION)


async def node_parameter(graph: TypedGraph, name: str, default: ParamValue = None) -> ParamValue:
    """Return `~name`, else `name`, else the default."""
    for each in (f"~{name}", name):
        if await graph.has_param(each):
            return await graph.get_param(each)
    return default


async def node_number(graph: TypedGraph, name: str, default: float) -> float:
    """Return a numeric parameter. Raises ConfigError."""
    return number(await node_parameter(graph, name, default), name)


async def node_bool(graph: TypedGraph, name: str, default: bool) -> bool:
    """Return a boolean parameter. Raises ConfigError."""
    value = await node_parameter(graph, name, default)
    if isinstance(value, bool | int):
        return bool(value)
    raise ConfigError(f"the parameter {name} must be true or false, not {value!r}")


async def node_mapping(graph: TypedGraph, name: str) -> Mapping[str, ParamValue]:
    """Return a parameter that maps names to values. Raises ConfigError."""
    value = await node_parameter(graph, name, {})
    if isinstance(value, dict):
        return value
    raise ConfigError(f"the parameter {name} must map joints to values, not {value!r}")


def number(value: ParamValue, what: str) -> float:
    """Return a parameter's value as a number. Raises ConfigError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"the parameter {what} must be a number, not {value!r}")
    return float(value)
