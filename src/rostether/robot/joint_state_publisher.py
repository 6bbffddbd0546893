"""The node joint_state_publisher: publishes positions from sources, sliders or zeros at a fixed rate."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable, Sequence
from contextlib import aclosing

from msgspec.structs import asdict

from rostether.errors import ConfigError
from rostether.graph.node_parameters import NodeParameters, as_number
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.tasks import run_until
from rostether.robot.joint_states import JointStates, JointStateSettings
from rostether.robot.robot_description import read_model
from rostether.robot.robot_model import Mimic, RobotModel

STATE_TYPE = "sensor_msgs/JointState"

# As in ROS.
DEFAULT_RATE_HZ = 10.0

# Sliders of other programs, such as the dashboard, publish positions on this topic.
SLIDERS_TOPIC = "~sliders"

# A higher rate is a mistake: no process can publish so fast.
MAX_RATE_HZ = 10_000.0


async def read_joint_states(graph: TypedGraph) -> JointStates:
    """Return the robot's joints with the settings of the parameters. Raises ConfigError, RobotModelError."""
    model = await read_model(graph)
    parameters = NodeParameters(graph, "")

    async def flag(name: str, default: bool) -> bool:
        return await parameters.flag(default, name, accepts_integers=True)

    settings = JointStateSettings(
        zeros=await _zeros(graph, model),
        dependent_joints={
            name: _mimic(name, value)
            for name, value in (await parameters.mapping("dependent_joints")).items()
        },
        use_mimic_tags=await flag("use_mimic_tags", True),
        use_smallest_joint_limits=await flag("use_smallest_joint_limits", True),
        publish_default_positions=await flag("publish_default_positions", True),
        publish_default_velocities=await flag("publish_default_velocities", False),
        publish_default_efforts=await flag("publish_default_efforts", False),
        delta=await parameters.number(0.0, "delta"),
    )
    return JointStates(model, settings)


async def publish_joint_states(
    graph: TypedGraph,
    states: JointStates,
    on_source: Callable[[], None] | None = None,
    more_sources: Sequence[str] = (),
) -> None:
    """Publish until canceled or until the node is shut down; `on_source` is called when a source publishes.

    `more_sources` are topics of positions besides those in the parameter source_list. Raises ConfigError for
    an invalid parameter.
    """
    parameters = NodeParameters(graph, "")
    rate_hz = await parameters.number(DEFAULT_RATE_HZ, "rate")
    if not 0 < rate_hz <= MAX_RATE_HZ:
        raise ConfigError(f"~rate must be above 0 and at most {MAX_RATE_HZ:g} Hz, not {rate_hz:g}")
    sources = await parameters.value([], "source_list")
    if not isinstance(sources, list) or not all(isinstance(each, str) for each in sources):
        raise ConfigError(f"~source_list must be a list of topics, not {sources!r:.200}")
    publisher = await graph.publisher("joint_states", STATE_TYPE)

    async def publish() -> None:
        async with asyncio.TaskGroup() as tasks:
            for source in (*sources, *more_sources):
                tasks.create_task(_listen(graph, str(source), states, on_source))
            await _publish_at_rate(graph, publisher, states, rate_hz)

    await run_until(publish(), graph.raw.wait_closed())


async def _publish_at_rate(
    graph: TypedGraph, publisher: TypedPublisher[...], states: JointStates, rate_hz: float
) -> None:
    loop = asyncio.get_running_loop()
    due_s = loop.time()
    # The first message has the number 1, as in rospy.
    for sequence in itertools.count(1):
        states.step()
        values = states.values()
        if values.name:
            header = {"seq": sequence & 0xFFFFFFFF, "stamp": graph.now()}
            publisher.publish(header=header, **asdict(values))
        # After a delay, continue from now instead of catching up in a burst.
        due_s = max(due_s + 1 / rate_hz, loop.time())
        await asyncio.sleep(due_s - loop.time())


async def _listen(
    graph: TypedGraph, topic: str, states: JointStates, on_source: Callable[[], None] | None
) -> None:
    async with aclosing(aiter(graph.messages(topic, STATE_TYPE))) as messages:
        async for message in messages:
            states.receive(message.name, message.position, message.velocity, message.effort)
            if on_source is not None:
                on_source()


async def _zeros(graph: TypedGraph, model: RobotModel) -> dict[str, float]:
    zeros = {}
    for name in ("zeros", "~zeros"):
        if await graph.has_param(name):
            value = await graph.get_param(name)
            if not isinstance(value, dict):
                raise ConfigError(f"{name} must map joints to positions, not {value!r:.200}")
            for joint, position in value.items():
                if joint in model.joints:
                    zeros[joint] = as_number(position, f"{name}/{joint}")
    return zeros


def _mimic(name: str, value: ParamValue) -> Mimic:
    if not isinstance(value, dict) or not isinstance(value.get("parent"), str):
        raise ConfigError(f"dependent_joints/{name} needs parent, and can have factor and offset")
    where = f"dependent_joints/{name}"
    return Mimic(
        str(value["parent"]),
        as_number(value.get("factor", 1.0), f"{where}/factor"),
        as_number(value.get("offset", 0.0), f"{where}/offset"),
    )
