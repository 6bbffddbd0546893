"""The node robot_state_publisher: publishes the robot's transforms from joint states."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import AsyncExitStack, aclosing

from rostether.graph.node_parameters import NodeParameters
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.block_end import task_beside
from rostether.robot.robot_description import read_model
from rostether.robot.robot_state import RobotState, RobotStateSettings
from rostether.robot.tf_messages import tf_publisher, tf_static_publisher, to_message
from rostether.rostime import NS_PER_S

# As in ROS. Joint states arrive fifty times a second, and each of them may have a problem.
WARNING_INTERVAL_S = 10.0

# Fixed transforms on /tf stay valid until the next ones arrive.
_FIXED_AHEAD_NS = NS_PER_S // 2

# Two seconds of one source; several sources may each publish some joints.
_QUEUE_MESSAGES = 100


async def publish_robot_state(graph: TypedGraph, warn: Callable[[str], None]) -> None:
    """Publish until canceled or until the node is shut down; `warn` gets problems with joint states.

    Raises ConfigError and RobotModelError if robot_description or a parameter is invalid.
    """
    state = RobotState(await read_model(graph), await _read_settings(graph))
    publisher = await tf_publisher(graph)
    loop = asyncio.get_running_loop()
    warn_again_s = 0.0
    stream = graph.messages("joint_states", "sensor_msgs/JointState", queue_size=_QUEUE_MESSAGES)
    async with AsyncExitStack() as stack:
        if state.settings.use_tf_static:
            static = await tf_static_publisher(graph)
            static.publish(to_message(state.fixed_transforms(graph.now().to_ns())))
        else:
            await stack.enter_async_context(task_beside(_publish_fixed(graph, state)))
        async for message in await stack.enter_async_context(aclosing(aiter(stream))):
            stamp_ns, now_ns = message.header.stamp.to_ns(), graph.now().to_ns()
            transforms = state.moving_transforms(message.name, message.position, stamp_ns, now_ns)
            if transforms:
                publisher.publish(to_message(transforms))
            if state.problem and loop.time() >= warn_again_s:
                warn_again_s = loop.time() + WARNING_INTERVAL_S
                warn(state.problem)


async def _read_settings(graph: TypedGraph) -> RobotStateSettings:
    prefix_name = await graph.search_param("tf_prefix")
    prefix = await graph.get_param(prefix_name) if prefix_name else ""
    return RobotStateSettings(
        publish_frequency_hz=await NodeParameters(graph).number(50.0, "publish_frequency"),
        use_tf_static=bool(await graph.get_param("~use_tf_static", True)),
        ignore_timestamp=bool(await graph.get_param("~ignore_timestamp", False)),
        tf_prefix=str(prefix),
    )


async def _publish_fixed(graph: TypedGraph, state: RobotState) -> None:
    publisher = await tf_publisher(graph)
    while True:
        transforms = state.fixed_transforms(graph.now().to_ns() + _FIXED_AHEAD_NS)
        if transforms:
            publisher.publish(to_message(transforms))
        await asyncio.sleep(state.settings.interval_ns / NS_PER_S)
