"""actionlib without ROS; tests/interop compares it with Debian's."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest_asyncio

from rostether.ros1.master.server import MasterServer
from unit.rospy_facade.programs import line_of, printed, started

SCRIPTS = Path(__file__).parents[2] / "interop" / "rospy_scripts"

CALLBACKS = """
import actionlib, rospy
from actionlib.msg import TestAction, TestFeedback, TestGoal, TestResult

rospy.init_node("both")
news = []

def execute(goal):
    for number in range(goal.goal):
        server.publish_feedback(TestFeedback(number))
    server.set_succeeded(TestResult(goal.goal), "done")

def done(state, result):
    news.append(("done", state, result.result))
    if result.result < 3:
        client.send_goal(TestGoal(result.result + 1), done, lambda: news.append("active"))

server = actionlib.SimpleActionServer("again", TestAction, execute, auto_start=False)
server.start()
client = actionlib.SimpleActionClient("again", TestAction)
print(client.wait_for_server(rospy.Duration(30)))
client.send_goal(TestGoal(1), done, lambda: news.append("active"))
print(client.wait_for_result(rospy.Duration(30)), client.get_goal_status_text())
print(news)
print(client.send_goal_and_wait(TestGoal(7), 30.0), client.get_result().result)
server.action_server.stop()
rospy.signal_shutdown("enough")
"""


@pytest_asyncio.fixture
async def master() -> AsyncIterator[str]:
    """Run our master."""
    server = await MasterServer.start(port=0)
    yield server.uri
    await server.close()


async def test_a_client_and_a_server(master: str) -> None:
    async with started(SCRIPTS / "action_server.py", "__name:=served", master_uri=master) as server:
        await line_of(server, "SERVING")
        lines = await printed(SCRIPTS / "action_client.py", "/served", master_uri=master)
    assert "1 SUCCEEDED 'fine' result: 11" in lines
    assert "3 ABORTED 'Exception in execute callback: broken' result: 0" in lines
    assert "pushed out PREEMPTED 'given up' result: 33" in lines
    assert "early [7]" in lines


async def test_callbacks_that_send_the_next_goal(master: str) -> None:
    lines = await printed(CALLBACKS, master_uri=master)
    assert lines == [
        "True",
        "True done",
        "['active', ('done', 3, 1), 'active', ('done', 3, 2), 'active', ('done', 3, 3)]",
        "3 7",
    ]
