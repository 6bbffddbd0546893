"""Serves actions in every way that actionlib has, until it gets a signal."""

import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestResult, TwoIntsAction, TwoIntsResult
from actionlib_msgs.msg import GoalStatus


class Executing:
    """A server with an execute callback; the goal selects its result."""

    def __init__(self):
        self.server = actionlib.SimpleActionServer("~executing", TestAction, self.execute, auto_start=False)
        self.server.start()

    def execute(self, goal):
        if goal.goal == 1:
            self.server.set_succeeded(TestResult(11), "fine")
        elif goal.goal == 2:
            self.server.set_aborted(TestResult(22), "no way")
        elif goal.goal == 3:
            raise ValueError("broken")
        elif goal.goal == 5:
            self.server.set_succeeded()
        elif goal.goal >= 100:
            while not self.server.is_preempt_requested() and not rospy.is_shutdown():
                self.server.publish_feedback(TestFeedback(goal.goal * 2))
                rospy.sleep(0.01)
            self.server.set_preempted(TestResult(33), "given up")


class Polling:
    """A server without an execute callback: it accepts goals by polling."""

    def __init__(self):
        self.server = actionlib.SimpleActionServer("~polling", TwoIntsAction, auto_start=False)
        self.server.register_goal_callback(self.accept)
        self.server.register_preempt_callback(self.give_up)
        self.server.start()

    def accept(self):
        goal = self.server.accept_new_goal()
        if goal.a >= 0:
            self.server.set_succeeded(TwoIntsResult(goal.a + goal.b))

    def give_up(self):
        if not self.server.is_new_goal_available():
            self.server.set_preempted(text="told to")


class Handling:
    """A server with many goals at the same time."""

    def __init__(self):
        self.goals = []
        self.server = actionlib.ActionServer(
            "~handling", TwoIntsAction, self.accept, self.cancel, auto_start=False
        )
        self.server.start()

    def accept(self, handle):
        a = handle.get_goal().a
        if a < 0:
            self.goals = []  # a new client begins
            handle.set_rejected(text="negative")
            return
        if a < 100:
            handle.set_accepted("working")
        self.goals.append(handle)
        if a == 2:
            self.goals[0].set_accepted("again")
            self.goals[1].set_succeeded(TwoIntsResult(a), "the second")

    def cancel(self, handle):
        status = handle.get_goal_status().status
        if status == GoalStatus.RECALLING or handle.get_goal().b == 1:
            handle.set_canceled(text="cancelled")
            self.goals = [each for each in self.goals if each != handle]


rospy.init_node("action_server")
servers = [Executing(), Polling(), Handling()]
print("SERVING")
rospy.spin()
