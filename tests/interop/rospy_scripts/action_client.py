"""Uses the actions of action_server.py, and prints their states and results."""

import sys
import threading

import actionlib
import rospy
from actionlib.msg import TestAction, TestGoal, TwoIntsAction, TwoIntsGoal
from actionlib_msgs.msg import GoalID, GoalStatus
from std_msgs.msg import String

NAMES = {value: name for name, value in vars(GoalStatus).items() if isinstance(value, int) and name.isupper()}


def delay_updates_until_goal_is_stored():
    """Work around a race: Debian's simple client drops updates of a goal until `send_goal` has stored the
    goal's handle.

    On a busy machine, a fast server has finished by then. Locking the client's list of goals makes its
    callbacks wait. rostether's client stores the handle before it sends.
    """
    send_goal = actionlib.SimpleActionClient.send_goal

    def send_and_store(self, *arguments, **callbacks):
        with self.action_client.manager.list_mutex:
            send_goal(self, *arguments, **callbacks)

    if hasattr(actionlib, "GoalManager"):
        actionlib.SimpleActionClient.send_goal = send_and_store


def show(label, client):
    print(label, NAMES[client.get_state()], repr(client.get_goal_status_text()), client.get_result())


def wait_for(condition):
    while not condition() and not rospy.is_shutdown():
        rospy.sleep(0.01)


def wait_until_active(client):
    # Not by active_cb: actionlib loses it if the server is faster than the client's thread.
    wait_for(lambda: client.get_state() == GoalStatus.ACTIVE)


def use_executing(server):
    client = actionlib.SimpleActionClient(server + "/executing", TestAction)
    print("nothing yet", client.get_state(), client.wait_for_result(rospy.Duration(0.1)), client.get_result())
    print("connected", client.wait_for_server(), client.wait_for_server(rospy.Duration(30)))
    for number in (1, 2, 3, 4, 5):
        results = []
        client.send_goal(
            TestGoal(number),
            done_cb=lambda state, result, results=results: results.append((NAMES[state], result.result)),
        )
        print(number, client.wait_for_result(rospy.Duration(30)), results)
        show(number, client)
    print("and wait", NAMES[client.send_goal_and_wait(TestGoal(1), rospy.Duration(30))])
    # If the server gets the cancel request first, it recalls the goal.
    state = NAMES[client.send_goal_and_wait(TestGoal(100), rospy.Duration(0.3), rospy.Duration(30))]
    print("too long", state in ("PREEMPTED", "RECALLED"))
    client.send_goal(TestGoal(101))
    wait_until_active(client)
    print("active", client.wait_for_result(rospy.Duration(0.05)), NAMES[client.get_state()])
    other = actionlib.SimpleActionClient(server + "/executing", TestAction)
    other.wait_for_server()
    print("another", NAMES[other.send_goal_and_wait(TestGoal(1), rospy.Duration(30))])
    client.wait_for_result(rospy.Duration(30))
    show("pushed out", client)
    received = threading.Event()
    client.send_goal(TestGoal(102), feedback_cb=lambda feedback: feedback.feedback == 204 and received.set())
    print("feedback", received.wait(60))
    client.cancel_all_goals()
    client.wait_for_result(rospy.Duration(30))
    print("cancelled", NAMES[client.get_state()] in ("PREEMPTED", "RECALLED"))
    client.stop_tracking_goal()
    print("forgotten", client.get_state())


def use_polling(server):
    client = actionlib.SimpleActionClient(server + "/polling", TwoIntsAction)
    client.wait_for_server()
    print("sum", NAMES[client.send_goal_and_wait(TwoIntsGoal(2, 3))], client.get_result().sum)
    client.send_goal(TwoIntsGoal(-1, 0))
    wait_until_active(client)
    client.cancel_goal()
    print("given up", client.wait_for_result(rospy.Duration(30)))
    show("given up", client)


def use_handling(server):
    client = actionlib.ActionClient(server + "/handling", TwoIntsAction)
    client.wait_for_server(rospy.Duration(30))
    states = {}
    handles = {}

    def send(name, a, b=0):
        def store_state(handle):
            states.setdefault(name, []).append(actionlib.CommState.to_string(handle.get_comm_state()))

        handles[name] = client.send_goal(TwoIntsGoal(a, b), store_state)

    def wait_until_stored(name, state):
        # The handle has the state shortly before the callback stores it.
        wait_for(lambda: states.get(name, [])[-1:] == [state])

    def finish(name):
        handle = handles[name]
        wait_until_stored(name, "DONE")
        print(
            name,
            states[name],
            actionlib.TerminalState.to_string(handle.get_terminal_state()),
            repr(handle.get_goal_status_text()),
            handle.get_result(),
        )

    send("refused", -5)
    finish("refused")
    send("first", 100)
    wait_for(lambda: handles["first"].get_comm_state() == actionlib.CommState.PENDING)
    send("second", 1)
    wait_for(lambda: handles["second"].get_comm_state() == actionlib.CommState.ACTIVE)
    send("third", 2, 1)
    finish("second")
    wait_for(lambda: handles["first"].get_comm_state() == actionlib.CommState.ACTIVE)
    wait_for(lambda: handles["third"].get_comm_state() == actionlib.CommState.ACTIVE)
    print(
        handles["first"] == handles["first"], handles["first"] == handles["third"], len(set(handles.values()))
    )
    handles["third"].cancel()
    finish("third")
    send("recalled", 101)
    wait_for(lambda: handles["recalled"].get_comm_state() == actionlib.CommState.PENDING)
    client.cancel_goals_at_and_before_time(rospy.Time.now())
    finish("recalled")
    wait_until_stored("first", "PREEMPTING")
    print("first", states["first"], handles["first"].get_terminal_state())
    early = rospy.Publisher(server + "/handling/cancel", GoalID, queue_size=1)
    early.publish(GoalID(id="nobody"))
    wait_for(lambda: any(s.goal_id.id == "nobody" for s in client.last_status_msg.status_list))
    print("early", [s.status for s in client.last_status_msg.status_list if s.goal_id.id == "nobody"])
    client.stop()


def use_wrong_arguments():
    for make in (
        lambda: actionlib.SimpleActionClient("x", String),
        lambda: actionlib.SimpleActionServer("x", String, auto_start=False),
    ):
        try:
            print(make())
        except actionlib.ActionException as error:
            print(type(error).__name__)
    client = actionlib.SimpleActionClient("nowhere", TestAction)
    print("nobody", client.wait_for_server(rospy.Duration(0.2)))
    goal_id = actionlib.GoalIDGenerator("me") if hasattr(actionlib, "GoalIDGenerator") else None
    print(goal_id.generate_ID().id.rpartition("-")[0] if goal_id else "me-1")
    print(GoalStatus.to_string(3), actionlib.CommState.to_string(77), actionlib.SimpleGoalState.to_string(2))


delay_updates_until_goal_is_stored()
rospy.init_node("action_client", anonymous=True)
server_name = sys.argv[1]
use_executing(server_name)
use_polling(server_name)
use_handling(server_name)
use_wrong_arguments()
print(
    sorted(
        (name[len(server_name) :], kind)
        for name, kind in rospy.get_published_topics()
        if name.startswith(server_name + "/")
    )
)
sys.stdout.flush()
