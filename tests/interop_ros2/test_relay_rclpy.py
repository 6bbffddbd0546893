"""Two processes of `rostether relay` between Debian's ROS 1 and plain rclpy.

The two recognize each other, and copy every message once.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from interop.ros1_peers import Ros1Peers, debian_roscore
from interop_ros2.rclpy_peer import RclpyPeer, rclpy_peer
from interop_ros2.samples import MESSAGES
from programs import Peer, start_command
from rostether.msgdef.registry import Registry

pytestmark = [
    pytest.mark.ros1,
    pytest.mark.rclpy,
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.timeout(300),
]

TIMEOUT_S = 60.0
SUCCEEDED = 4
SERVER = """
import rospy
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node("server")
rospy.Service("/enable", SetBool, lambda asked: SetBoolResponse(asked.data, "from ROS 1"))
print("serving", flush=True)
rospy.spin()
"""
COUNTER = """
import rospy
from sensor_msgs.msg import JointState
rospy.init_node("counter")
publisher = rospy.Publisher("/sensors/joints", JointState, queue_size=1000)
number = 0
while not rospy.is_shutdown():
    number += 1
    publisher.publish(JointState(name=["left", "right"], position=[number, 0.5]))
    rospy.sleep(0.05)
"""
TALKER = """
import rospy
from std_msgs.msg import String
rospy.init_node("talker")
publisher = rospy.Publisher("/chatter", String, queue_size=1000)
number = 0
while not rospy.is_shutdown():
    number += 1
    publisher.publish("from ROS 1: %d" % number)
    rospy.sleep(0.02)
"""

# Debian's actionlib: a server of /count_1, and a client of /count_2.
COUNTING = """
import sys, actionlib, genpy.dynamic, rospy
types = genpy.dynamic.generate_dynamic("test_msgs/FibonacciAction", sys.stdin.read())
Action, Goal, Feedback, Result = (types["test_msgs/Fibonacci" + each] for each in
                                  ("Action", "Goal", "Feedback", "Result"))
def count(goal):
    numbers = [0, 1]
    while len(numbers) <= goal.order:
        numbers.append(numbers[-1] + numbers[-2])
    server.publish_feedback(Feedback(numbers[:-1]))
    server.set_succeeded(Result(numbers))
rospy.init_node("counting")
server = actionlib.SimpleActionServer("/count_1", Action, count, auto_start=False)
server.start()
client = actionlib.SimpleActionClient("/count_2", Action)
client.wait_for_server()
client.send_goal_and_wait(Goal(3))
print(actionlib.TerminalState.to_string(client.get_state()), list(client.get_result().sequence), flush=True)
rospy.spin()
"""
ACTION = "test_msgs/Fibonacci"


@dataclass
class Sides:
    """The nodes on both sides of the relays, and the relays, the older one first."""

    ros1: Ros1Peers
    ros2: RclpyPeer
    relays: list[Peer]
    definitions: Path


@pytest.fixture(scope="module")
def peer() -> Iterator[RclpyPeer]:
    with rclpy_peer() as peer:
        yield peer


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def sides(peer: RclpyPeer, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Sides]:
    folder = tmp_path_factory.mktemp("definitions")
    file = folder / "test_msgs" / "action" / "Fibonacci.action"
    file.parent.mkdir(parents=True)
    file.write_text("int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n")
    async with AsyncExitStack() as stack:
        ros1 = await stack.enter_async_context(debian_roscore(tmp_path_factory.mktemp("home")))
        command = ("relay", "--ros2", "rclpy", "/chatter", "--to-ros2", "/sensors/*", "--to-ros1", "/cmd_vel")
        services = ("--service", "/enable", "--service", "/pull")
        actions = ("--action", "/count_*", "--msg-path", str(folder))
        relays = []
        for _ in range(2):
            relay = await start_command(*command, *services, *actions, "--master", ros1.master_uri)
            stack.push_async_callback(relay.stop)
            await relay.wait_for("Joining ROS 2", TIMEOUT_S)
            relays.append(relay)
        for relay in relays:
            await relay.wait_for("connects the same graphs", TIMEOUT_S)
        yield Sides(ros1, peer, relays, folder)


async def wait_for_messages(peer: RclpyPeer, topic: str, count: int) -> list[Any]:
    """Wait until ROS 2 has received `count` messages."""
    while len(found := await peer.ask("receive", topic=topic, count=0)) < count:
        await asyncio.sleep(0.05)
    assert isinstance(found, list)
    return found


async def test_ros2_receives_each_message_of_ros1_once(sides: Sides) -> None:
    await sides.ros2.ask("subscribe", topic="/sensors/joints", type="sensor_msgs/msg/JointState")
    counter = await sides.ros1.rospy(COUNTER)
    # The peer's queue has 100 places, enough for a pause of a few seconds on a busy machine.
    joints = await wait_for_messages(sides.ros2, "/sensors/joints", 40)
    await counter.stop()
    assert joints[0]["name"] == ["left", "right"]
    numbers = [each["position"][0] for each in joints]
    assert numbers == [numbers[0] + index for index in range(len(numbers))]


async def test_ros1_receives_messages_of_ros2(sides: Sides) -> None:
    echo = await sides.ros1.start("rostopic", "echo", "/cmd_vel")
    await sides.ros2.ask("advertise", topic="/cmd_vel", type="geometry_msgs/msg/Twist")
    while "z: 3.0" not in echo.text:
        await sides.ros2.ask("publish", topic="/cmd_vel", messages=[MESSAGES["geometry_msgs/Twist"]])
        await asyncio.sleep(0.1)
    await echo.stop()


async def test_messages_are_not_sent_back(sides: Sides) -> None:
    await sides.ros2.ask("subscribe", topic="/chatter", type="std_msgs/msg/String")
    echo = await sides.ros1.start("rostopic", "echo", "/chatter")
    talker = await sides.ros1.rospy(TALKER)
    await wait_for_messages(sides.ros2, "/chatter", 20)
    await talker.stop()
    await sides.ros2.ask("advertise", topic="/chatter", type="std_msgs/msg/String")
    reported = 0
    while "from ROS 2" not in echo.text:
        reported += 1
        await sides.ros2.ask("publish", topic="/chatter", messages=[{"data": f"from ROS 2: {reported}"}])
        await asyncio.sleep(0.1)
    texts = [each["data"] for each in await sides.ros2.ask("receive", topic="/chatter", count=0)]
    assert len(texts) == len(set(texts))
    printed = [line for line in echo.lines if line.startswith("data")]
    assert len(printed) == len(set(printed))
    await echo.stop()


async def test_services_are_called_from_the_other_graph(sides: Sides) -> None:
    server = await sides.ros1.rospy(SERVER)
    await server.wait_for("serving")
    answered = await sides.ros2.ask(
        "call", service="/enable", type="std_srvs/srv/SetBool", request={"data": True}
    )
    assert answered == {"success": True, "message": "from ROS 1"}
    response = {"success": True, "message": "from ROS 2"}
    await sides.ros2.ask("serve", service="/pull", type="std_srvs/srv/Trigger", response=response)
    while "/pull" not in (await sides.ros1.run("rosservice", "list")).split():
        await asyncio.sleep(0.1)
    assert '"from ROS 2"' in await sides.ros1.run("rosservice", "call", "/pull")
    await server.stop()


async def test_actions_are_called_from_the_other_graph(sides: Sides) -> None:
    if find_spec("test_msgs") is None:
        pytest.skip("test_msgs is not installed: pip install ros-test-msgs")
    ros2, action = sides.ros2, ACTION.replace("/", "/action/")
    await ros2.ask("serve_action", action="/count_2", type=action, result={"sequence": [0, 1, 1, 2]})
    text = Registry([sides.definitions]).message_type(f"{ACTION}Action").definition
    counting = await sides.ros1.start("python", "-c", COUNTING, stdin=text.encode())
    answer = await ros2.ask("send_goal", action="/count_1", type=action, goal={"order": 5})
    assert answer["status"] == SUCCEEDED, (answer, counting.text, [relay.text for relay in sides.relays])
    assert answer["result"] == {"sequence": [0, 1, 1, 2, 3, 5]}
    await counting.wait_for("SUCCEEDED [0, 1, 1, 2]")
    await counting.stop()


async def test_the_second_relay_continues_when_the_first_is_killed(sides: Sides) -> None:
    response = {"success": True, "message": "from ROS 2"}
    await sides.ros2.ask("serve", service="/pull", type="std_srvs/srv/Trigger", response=response)
    while "/pull" not in (await sides.ros1.run("rosservice", "list")).split():
        await asyncio.sleep(0.1)
    for relay in sides.relays[:1]:
        relay.process.kill()
        await relay.finish()
    # DDS lists the killed relay for 20 s more; ROS 1 would list it forever.
    await sides.relays[1].wait_for("was killed: removed its registrations", TIMEOUT_S)
    while '"from ROS 2"' not in await sides.ros1.run("rosservice", "call", "/pull", check=False):
        await asyncio.sleep(0.1)
