"""Reads the parameter robot_description: the private one, else a remapped one, else the nearest one."""

from __future__ import annotations

from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.robot.robot_model import RobotModel
from rostether.robot.urdf import parse_urdf

DESCRIPTION = "robot_description"


async def read_model(graph: TypedGraph) -> RobotModel:
    """Return the robot. Raises RobotModelError, ConfigError if no parameter has a URDF."""
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
