from __future__ import annotations

import asyncio

import pytest

from rostether.errors import ConfigError, RobotModelError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import ParamValue
from rostether.mechanisms.block_end import task_beside
from rostether.robot.robot_state_publisher import publish_robot_state
from rostether.robot.tf_messages import TF_TYPE, from_message
from unit.robot.graphs import entered, first
from unit.robot.robots import ARM, ROVER

STATE = "sensor_msgs/JointState"


async def test_joint_states_become_transforms() -> None:
    network = MemoryNetwork()
    warnings: list[str] = []
    async with entered(network, "/rsp") as node, entered(network, "/arm") as arm:
        await arm.set_param("/robot_description", ARM)
        async with task_beside(publish_robot_state(node, warnings.append)):
            states = await arm.publisher("/joint_states", STATE)
            assert await states.wait_for_subscriber(5)
            waiting = asyncio.ensure_future(first(arm, "/tf", TF_TYPE))
            fixed = await first(arm, "/tf_static", TF_TYPE)
            while not waiting.done():
                states.publish(header={"stamp": arm.now()}, name=["j0", "j1", "j9"], position=[0.1, 0.2, 0.3])
                await asyncio.wait([waiting], timeout=0.05)
    assert [each.child for each in from_message(fixed)] == ["hand"]
    assert [each.child for each in from_message(await waiting)] == ["turret", "upper"]
    assert len(warnings) == 1
    assert "'j9'" in warnings[0]


async def test_fixed_transforms_on_tf_are_stamped_ahead() -> None:
    network = MemoryNetwork()
    async with entered(network, "/rsp") as node, entered(network, "/eye") as eye:
        parameters: dict[str, ParamValue] = {
            "/robot_description": ROVER,
            "/rsp/use_tf_static": False,
            "/tf_prefix": "r1",
        }
        for name, value in parameters.items():
            await eye.set_param(name, value)
        async with task_beside(publish_robot_state(node, print)):
            message = await first(eye, "/tf", TF_TYPE)
            now_ns = eye.now().to_ns()
    fixed = list(from_message(message))
    assert [(each.parent, each.child) for each in fixed] == [("r1/foot", "r1/body"), ("r1/body", "r1/sled")]
    assert fixed[0].stamp_ns > now_ns


async def test_a_missing_or_invalid_description_is_refused() -> None:
    network = MemoryNetwork()
    async with entered(network, "/rsp") as node:
        with pytest.raises(ConfigError, match="the parameter robot_description"):
            await publish_robot_state(node, print)
        await node.set_param("/robot_description", "<robot/>")
        with pytest.raises(RobotModelError, match="robot_description:1: the robot has no name"):
            await publish_robot_state(node, print)
        await node.set_param("/robot_description", ARM)
        await node.set_param("/rsp/publish_frequency", "often")
        with pytest.raises(ConfigError, match="publish_frequency must be a number"):
            await publish_robot_state(node, print)
