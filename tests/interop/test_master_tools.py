"""Debian's tools and nodes with rostether's master instead of roscore."""

from __future__ import annotations

import os
import signal
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from interop.ros1_peers import Ros1Peers
from programs import Peer
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.roscore import Roscore

ROBOT = """
import rospy, sys
from std_msgs.msg import String
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node(sys.argv[1])
chat = rospy.Publisher("/chat", String, queue_size=1)
rospy.Subscriber("/orders", String, lambda order: print("order", order.data, flush=True))
rospy.Service("~lamp", SetBool, lambda request: SetBoolResponse(True, "lamp %s" % request.data))
rospy.set_param("~speed", 3)
print("robot is up", flush=True)
rate = rospy.Rate(50)
while not rospy.is_shutdown():
    chat.publish("tick")
    rate.sleep()
print("robot leaves", flush=True)
"""

WATCHER = """
import rospy, sys
rospy.init_node("watcher", disable_signals=True)
seen = None
print("watches", rospy.get_param_cached("/gains/p", None), flush=True)
while not rospy.is_shutdown():
    value = rospy.get_param_cached("/gains/p", None)
    if value != seen:
        seen = value
        print("now", value, flush=True)
    rospy.sleep(0.01)
"""

LOGGER = """
import rospy
from rosgraph_msgs.msg import Log
rospy.init_node("late")
def handle(log):
    print(log.msg, flush=True)
    rospy.signal_shutdown("done")
rospy.Subscriber("/rosout_agg", Log, handle)
while not rospy.is_shutdown():
    rospy.logwarn("still here")
    rospy.rostime.wallsleep(0.05)
"""


@pytest_asyncio.fixture
async def peers(tmp_path: Path) -> AsyncIterator[Ros1Peers]:
    core = await Roscore.start(RosEnvironment(), port=0)
    peers = Ros1Peers(core.uri, tmp_path)
    yield peers
    await peers.close()
    await core.close()


async def start_robot(peers: Ros1Peers, name: str = "robot") -> Peer:
    node = await peers.rospy(ROBOT, name)
    await node.wait_for("robot is up")
    return node


async def test_nodes_and_topics_are_listed(peers: Ros1Peers) -> None:
    await start_robot(peers)
    assert (await peers.run("rosnode", "list")).splitlines() == ["/robot", "/rosout"]
    assert "xmlrpc reply from" in await peers.run("rosnode", "ping", "-c", "1", "/robot")
    assert " * /robot/lamp" in await peers.run("rosnode", "info", "/robot")
    assert (await peers.run("rostopic", "list")).splitlines() == [
        "/chat",
        "/orders",
        "/rosout",
        "/rosout_agg",
    ]
    assert " * /chat [std_msgs/String] 1 publisher" in await peers.run("rostopic", "list", "-v")
    assert await peers.run("rostopic", "type", "/orders") == "std_msgs/String"
    assert await peers.run("rostopic", "find", "std_msgs/String") == "/chat\n/orders"
    assert " * /robot (http://" in await peers.run("rostopic", "info", "/chat")


async def test_messages_flow_between_nodes(peers: Ros1Peers) -> None:
    node = await start_robot(peers)
    assert 'data: "tick"' in await peers.run("rostopic", "echo", "-n", "2", "/chat")
    hz = await peers.start("rostopic", "hz", "/chat")
    await hz.wait_for("average rate: ")
    await hz.stop()
    await peers.run("rostopic", "pub", "-1", "/orders", "std_msgs/String", "go")
    await node.wait_for("order go")


async def test_services_are_found_and_called(peers: Ros1Peers) -> None:
    await start_robot(peers)
    assert "/robot/lamp" in (await peers.run("rosservice", "list")).splitlines()
    assert "Type: std_srvs/SetBool" in await peers.run("rosservice", "info", "/robot/lamp")
    assert await peers.run("rosservice", "find", "std_srvs/SetBool") == "/robot/lamp"
    assert 'message: "lamp True"' in await peers.run("rosservice", "call", "/robot/lamp", "true")


@pytest.mark.roscpp
async def test_roscpp_nodes_find_each_other(peers: Ros1Peers) -> None:
    listener = await peers.roscpp("listen", "/cpp", "3")
    await peers.roscpp("talk", "/cpp", "5", "20")
    assert "message " in await listener.finish()
    await peers.roscpp("serve", "/lamp")
    waiting = "import rospy; rospy.wait_for_service('/lamp', 60)"
    await peers.run("python", "-c", waiting)
    caller = await peers.roscpp("call", "/lamp", "true", "1")
    await caller.finish()
    assert caller.process.returncode == 0


async def test_parameters(peers: Ros1Peers, tmp_path: Path) -> None:
    await start_robot(peers)
    assert await peers.run("rosparam", "get", "/robot/speed") == "3"
    await peers.run(
        "rosparam", "set", "/arm", "{gains: {p: 1.5, i: 2}, name: 'left arm', up: true, list: [1, a]}"
    )
    assert await peers.run("rosparam", "get", "/arm/gains/p") == "1.5"
    assert "/arm/gains/i" in (await peers.run("rosparam", "list")).splitlines()
    dump = tmp_path / "arm.yaml"
    await peers.run("rosparam", "dump", str(dump), "/arm")
    await peers.run("rosparam", "delete", "/arm")
    assert "is not set" in await peers.run("rosparam", "get", "/arm", check=False)
    await peers.run("rosparam", "load", str(dump), "/other")
    assert await peers.run("rosparam", "get", "/other/name") == "left arm"
    assert await peers.run("rosparam", "get", "/other/up") == "true"
    assert await peers.run("rosparam", "get", "/other/list") == "- 1\n- a\n"
    assert await peers.run("rosparam", "get", "/rosdistro") == "'noetic\n\n  '\n"


async def test_a_cached_parameter_is_updated(peers: Ros1Peers) -> None:
    watcher = await peers.rospy(WATCHER)
    await watcher.wait_for("watches None")
    await peers.run("rosparam", "set", "/gains/p", "7")
    await watcher.wait_for("now 7")
    await peers.run("rosparam", "set", "/gains", "{p: 8, i: 1}")
    await watcher.wait_for("now 8")


async def test_a_second_node_of_the_name_replaces_the_first(peers: Ros1Peers) -> None:
    first = await start_robot(peers)
    await start_robot(peers)
    text = await first.finish()
    assert "shutdown request: [/robot] Reason: new node registered with same name" in text
    assert (await peers.run("rosnode", "list")).splitlines() == ["/robot", "/rosout"]
    assert 'data: "tick"' in await peers.run("rostopic", "echo", "-n", "1", "/chat")


async def test_a_killed_node_is_removed_automatically(peers: Ros1Peers) -> None:
    node = await start_robot(peers)
    listener = await peers.start("rostopic", "echo", "/chat")
    await listener.wait_for("tick")
    os.killpg(node.process.pid, signal.SIGKILL)
    script = """
import rosgraph, sys, time
master = rosgraph.Master("/test")
for _ in range(1200):
    if not any("/robot" in nodes for table in master.getSystemState() for _, nodes in table):
        sys.exit(0)
    time.sleep(0.05)
sys.exit(1)
"""
    await peers.run("python", "-c", script)
    assert "/robot" not in (await peers.run("rosnode", "list")).splitlines()


async def test_rosout_restarts_after_rosnode_kill_all(peers: Ros1Peers) -> None:
    node = await start_robot(peers)
    assert " * /robot" in await peers.run("rosnode", "kill", "-a")
    assert "robot leaves" in await node.finish()
    assert "still here" in await peers.run("python", "-c", LOGGER)


async def test_roslaunch_uses_the_running_master(peers: Ros1Peers, tmp_path: Path) -> None:
    launch = tmp_path / "robot.launch"
    launch.write_text(
        '<launch><param name="wheels" value="4"/>'
        '<group ns="arm"><rosparam>{reach: 0.5, joints: [a, b]}</rosparam></group></launch>'
    )
    text = await peers.run("roslaunch", str(launch))
    assert "auto-starting new master" not in text
    assert await peers.run("rosparam", "get", "/wheels") == "4"
    assert await peers.run("rosparam", "get", "/arm") == "joints:\n- a\n- b\nreach: 0.5\n"


async def test_roswtf_finds_no_error(peers: Ros1Peers, tmp_path: Path) -> None:
    await start_robot(peers)
    listener = await peers.start("rostopic", "echo", "/chat")
    await listener.wait_for("tick")
    # roswtf requires two folders: Debian has no ROS_ROOT, and the first program that logs creates ROS_HOME.
    (tmp_path / "ros").mkdir()
    (tmp_path / ".ros").mkdir(exist_ok=True)
    peers.environment["ROS_ROOT"] = str(tmp_path / "ros")
    text = await peers.run("roswtf", timeout_s=60)
    assert "running graph rules" in text
    assert "error(s)" not in text
    assert "ERROR" not in text
