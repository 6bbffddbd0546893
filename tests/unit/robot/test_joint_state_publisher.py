from __future__ import annotations

import asyncio

import pytest

from rostether.errors import ConfigError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import ParamValue
from rostether.mechanisms.block_end import task_beside
from rostether.robot.joint_state_publisher import SLIDERS_TOPIC, publish_joint_states, read_joint_states
from unit.robot.graphs import entered, first
from unit.robot.robots import ARM

STATE = "sensor_msgs/JointState"


async def test_sources_and_parameters_are_used() -> None:
    network = MemoryNetwork()
    received: list[None] = []
    async with entered(network, "/jsp") as node, entered(network, "/arm") as arm:
        parameters: dict[str, ParamValue] = {
            "/robot_description": ARM,
            "/jsp/rate": 200,
            "/jsp/zeros": {"j0": 0.25, "other": "x"},
            "/jsp/source_list": ["/source"],
            "/dependent_joints": {"j2": {"parent": "j0", "factor": 2}},
        }
        for name, value in parameters.items():
            await node.set_param(name, value)
        states = await read_joint_states(node)
        async with task_beside(
            publish_joint_states(node, states, lambda: received.append(None), [SLIDERS_TOPIC])
        ):
            before = await first(arm, "/joint_states", STATE)
            source = await arm.publisher("/source", STATE)
            assert await source.wait_for_subscriber(5)
            source.publish(name=["j1"], position=[0.75])
            after = await first(arm, "/joint_states", STATE, lambda message: 0.75 in message.position)
            sliders = await arm.publisher("/jsp/sliders", STATE)
            assert await sliders.wait_for_subscriber(5)
            sliders.publish(name=["j0"], position=[0.5])
            moved = await first(arm, "/joint_states", STATE, lambda message: message.position[0] == 0.5)
    assert before.name == ["j0", "j1", "j2"]
    assert before.position == [0.25, 0.0, 0.5]
    assert before.header.stamp.secs > 0
    assert 0 < before.header.seq < after.header.seq
    assert after.position == [0.25, 0.75, 0.5]
    assert moved.position == [0.5, 0.75, 1.0]
    assert received == [None, None]


@pytest.mark.parametrize(
    ("name", "value", "reported"),
    [
        ("rate", 0, "above 0 and at most"),
        ("rate", "fast", "must be a number"),
        ("source_list", "topic", "list of topics"),
        ("zeros", [1], "map joints to positions"),
        ("zeros", {"j0": "x"}, "zeros/j0 must be a number"),
        ("dependent_joints", {"j0": 5}, "needs parent"),
        ("dependent_joints", 5, "must map names"),
        ("use_mimic_tags", "maybe", "must be true or false"),
    ],
)
async def test_invalid_parameters_are_refused(name: str, value: ParamValue, reported: str) -> None:
    async with entered(MemoryNetwork(), "/jsp") as node:
        await node.set_param("/robot_description", ARM)
        await node.set_param(f"/jsp/{name}", value)
        with pytest.raises(ConfigError, match=reported):
            await publish_joint_states(node, await read_joint_states(node))


async def test_publishing_ends_with_the_node() -> None:
    network = MemoryNetwork()
    async with entered(network, "/jsp") as node, entered(network, "/arm") as arm:
        await node.set_param("/robot_description", ARM)
        async with task_beside(publish_joint_states(node, await read_joint_states(node))) as publishing:
            await first(arm, "/joint_states", STATE)
            await node.close()
            await asyncio.wait_for(publishing, 60)
