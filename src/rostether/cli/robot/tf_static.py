"""`rostether tf static`, and the nodes static_transform_publisher of tf and tf2_ros: the same arguments."""

from __future__ import annotations

import os

import click

from rostether.cli.access.graph_options import ROS2_CHOICE
from rostether.cli.role.node import RoleVerb, node_arguments, role_node
from rostether.cli.shell.verbs import verb
from rostether.names.graph_name import validate_name
from rostether.robot.static_transforms import (
    StaticTransform,
    parse_static_transform,
    publish_static_transform,
    static_transform_of,
)

_WORDS = "X Y Z YAW PITCH ROLL PARENT CHILD | X Y Z QX QY QZ QW PARENT CHILD | PARAMETER"
_arguments = click.argument("words", nargs=-1, type=click.UNPROCESSED, metavar=_WORDS)


@verb(
    "static",
    """
    rostether tf static 0 0 0.1 0 0 0 base_link laser
    rostether tf static 0 0 0.1 0 0 0 1 base_link laser
    rostether tf static 0 0 0.1 0 0 0 base_link laser 100     (on /tf, every 100 ms)
    rostether tf static --ros2 0 0 0.1 0 0 0 base_link laser
    rostether tf static --ros2 --z 0.1 --yaw 1.57 --frame-id base_link --child-frame-id laser
    """,
    cls=RoleVerb,
)
@_arguments
@ROS2_CHOICE
async def static(words: tuple[str, ...], ros2: str | None) -> None:
    """Publish the transform from PARENT to CHILD on /tf_static until Ctrl-C.

    The units are meters, and radians or a quaternion. With a number of milliseconds at the end, it publishes
    repeatedly on /tf, like tf's node. PARAMETER contains a geometry_msgs/TransformStamped.

    The options of ROS 2's node work too: --x, --y, --z, --yaw, --pitch, --roll, --qx, --qy, --qz, --qw,
    --frame-id and --child-frame-id. A number that is omitted is 0; --qw is 1.
    """
    await _publish(words, ros2)


@verb(
    "static-transform-publisher",
    """
    rostether role static-transform-publisher 0 0 0.1 0 0 0 base_link laser
    rostether role tf-static-transform-publisher 0 0 0.1 0 0 0 base_link laser 100
    """,
    cls=RoleVerb,
)
@_arguments
async def static_transform_publisher(words: tuple[str, ...]) -> None:
    """Publish a static transform, like static_transform_publisher of tf2_ros and tf."""
    await _publish(words)


async def _publish(words: tuple[str, ...], ros2: str | None = None) -> None:
    arguments = node_arguments(words)
    if len(arguments.rest) == 1:
        transform: StaticTransform | None = None
        validate_name(arguments.rest[0])
    else:
        transform = parse_static_transform(arguments.rest)
    async with role_node(arguments, f"static_transform_publisher_{os.getpid()}", ros2) as graph:
        if transform is None:
            name = arguments.rest[0]
            transform = static_transform_of(await graph.get_param(name), name)
        await publish_static_transform(graph, transform)
