"""rostether's nodes with Debian's tools: rosnode, rostopic, rosparam, and logs in /rosout."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import SET_BOOL, STRING
from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from rostether.graph.ports import Level, ParamValue
from waiting import until

LOG_ECHO = """
import rospy
from rosgraph_msgs.msg import Log
rospy.init_node("py_log")
def handle(log):
    if log.name == "/board":
        print(log.level, log.name, log.msg, sorted(log.topics), log.header.stamp.secs > 0, flush=True)
        rospy.signal_shutdown("done")
rospy.Subscriber("/rosout", Log, handle)
rospy.spin()
"""


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


async def echo_request(request: bytes) -> bytes:
    return request


@ON_BOTH_MASTERS
async def test_rosnode_and_rostopic_show_a_node(stage: Stage) -> None:
    board, other = await stage.join("/board"), await stage.join("/other")
    publisher = await board.advertise("/chat", STRING)
    await board.subscribe("/orders", STRING, lambda _: None)
    await board.advertise_service("/switch", SET_BOOL, echo_request)
    subscriber = await other.subscribe("/chat", STRING, lambda _: None)
    await until(lambda: publisher.subscriber_count == subscriber.publisher_count == 1)

    assert "/board" in (await stage.peers.run("rosnode", "list")).splitlines()
    info = await stage.peers.run("rosnode", "info", "/board")
    assert " * /chat [std_msgs/String]" in info
    assert " * /orders [unknown type]" in info or " * /orders [std_msgs/String]" in info
    assert " * /switch" in info
    assert "Pid: " in info
    # The connection, its direction and its ports.
    assert " * topic: /chat" in info
    assert "    * to: /other" in info
    assert "    * direction: outbound (" in info
    assert "    * transport: TCPROS" in info
    assert "    * direction: inbound (" in await stage.peers.run("rosnode", "info", "/other")
    assert "xmlrpc reply from" in await stage.peers.run("rosnode", "ping", "-c", "2", "/board")

    topics = (await stage.peers.run("rostopic", "list")).splitlines()
    assert {"/chat", "/orders", "/rosout"} <= set(topics)
    topic = await stage.peers.run("rostopic", "info", "/chat")
    assert "Type: std_msgs/String" in topic
    assert f" * /board ({board.node_uri})" in topic
    assert f" * /other ({other.node_uri})" in topic
    assert await stage.peers.run("rostopic", "type", "/chat") == "std_msgs/String"


@ON_BOTH_MASTERS
async def test_rosnode_kill_ends_a_node(stage: Stage) -> None:
    board = await stage.join("/board")
    await board.advertise("/chat", STRING)
    assert "killed" in await stage.peers.run("rosnode", "kill", "/board")
    assert "user request" in await board.wait_closed()
    assert "/board" not in (await stage.peers.run("rosnode", "list")).splitlines()


@ON_BOTH_MASTERS
async def test_rosparam_and_a_node_see_each_others_parameters(stage: Stage) -> None:
    board = await stage.join("/board")
    seen: list[ParamValue] = []
    await board.watch_param("/gains", seen.append)
    await stage.peers.run("rosparam", "set", "/gains", "{p: 1.5, names: [a, b], fast: true}")
    # rosparam sets the leaves one by one.
    await until(lambda: seen[-1] == {"p": 1.5, "names": ["a", "b"], "fast": True})
    assert seen[0] is None
    await board.set_param("/gains/p", 2)
    assert await stage.peers.run("rosparam", "get", "/gains/p") == "2"
    await stage.peers.run("rosparam", "delete", "/gains")
    await until(lambda: seen[-1] is None)


@ON_BOTH_MASTERS
async def test_logs_reach_rosout(stage: Stage) -> None:
    board = await stage.join("/board")
    await board.advertise("/chat", STRING)
    board.log(Level.ERROR, "too hot: 90 °C")
    peer = await stage.peers.rospy(LOG_ECHO)
    assert await peer.finish() == "8 /board too hot: 90 °C ['/chat', '/rosout'] True"


@ON_BOTH_MASTERS
async def test_roswtf_finds_no_error_in_nodes_of_rostether(stage: Stage, tmp_path: Path) -> None:
    board, other = await stage.join("/board"), await stage.join("/other")
    publisher = await board.advertise("/chat", STRING)
    subscriber = await other.subscribe("/chat", STRING, lambda _: None)
    await board.advertise_service("/switch", SET_BOOL, echo_request)
    await until(lambda: publisher.subscriber_count == subscriber.publisher_count == 1)
    await stage.wait_for_rosout("/board", "/other")
    # Debian has no ROS_ROOT folder; roswtf would call that an error.
    (tmp_path / "ros").mkdir()
    stage.peers.environment["ROS_ROOT"] = str(tmp_path / "ros")
    text = await stage.peers.run("roswtf", timeout_s=60)
    online = text.partition("Beginning tests of your ROS graph")[2]
    assert "... done running graph rules" in online
    assert "ERROR" not in online
    assert "WARNING" not in online
