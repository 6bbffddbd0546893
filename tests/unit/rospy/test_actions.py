"""actionlib without ROS; tests/interop compares it with Debian's."""

from __future__ import annotations

from pathlib import Path

from unit.rospy.programs import line_of, printed, running_script

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
client.cancel_goal()
print(client.gh.get_comm_state() == actionlib.CommState.DONE, client.get_state())
print(client.send_goal_and_wait(TestGoal(7), 30.0), client.get_result().result)
server.action_server.stop()
rospy.signal_shutdown("enough")
"""


async def test_a_client_and_a_server(master: str) -> None:
    async with running_script(SCRIPTS / "action_server.py", "__name:=served", master_uri=master) as server:
        await line_of(server, "SERVING")
        lines = await printed(SCRIPTS / "action_client.py", "/served", master_uri=master)
    assert "1 SUCCEEDED 'fine' result: 11" in lines
    assert "3 ABORTED 'Exception in execute callback: broken' result: 0" in lines
    assert "pushed out PREEMPTED 'given up' result: 33" in lines
    assert "early [7]" in lines


WASH = """
import actionlib, rospy
from kitchen.msg import WashAction, WashFeedback, WashGoal, WashResult

rospy.init_node("kitchen")
server = actionlib.SimpleActionServer("wash", WashAction, auto_start=False)
server.register_goal_callback(
    lambda: server.set_succeeded(WashResult(clean=[each.upper() for each in server.accept_new_goal().dishes]))
)
server.start()
client = actionlib.SimpleActionClient("wash", WashAction)
client.wait_for_server()
print(client.send_goal_and_wait(WashGoal(dishes=["cup"])), client.get_result().clean, WashGoal.SOAP)
served = server.action_server
print(WashFeedback._type, served.status_frequency, served.status_list_timeout.secs)
rospy.signal_shutdown("enough")
"""


async def test_an_action_of_a_package_of_the_user(master: str, tmp_path: Path) -> None:
    folder = tmp_path / "kitchen"
    (folder / "action").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>kitchen</name></package>")
    (folder / "action" / "Wash.action").write_text(
        "int32 SOAP=3\nstring[] dishes\n---\nstring[] clean\n---\nfloat32 share\n"
    )
    parameters = "import rospy; rospy.set_param('/actionlib_status_frequency', 10); "
    parameters += "rospy.set_param('/wash/status_list_timeout', 7.5)"
    await printed(parameters, master_uri=master)
    lines = await printed(WASH, master_uri=master, environ={"ROS_PACKAGE_PATH": str(tmp_path)})
    assert lines == ["3 ['CUP'] 3", "kitchen/WashFeedback 10.0 7"]


async def test_callbacks_that_send_the_next_goal(master: str) -> None:
    lines = await printed(CALLBACKS, master_uri=master)
    assert lines == [
        "True",
        "True done",
        "['active', ('done', 3, 1), 'active', ('done', 3, 2), 'active', ('done', 3, 3)]",
        "True 3",
        "3 7",
    ]
