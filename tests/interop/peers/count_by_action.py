"""A client of the action `fibonacci` with Debian's actionlib; its argument is the file of the full text.

Prints the final states and results of four goals: reached, canceled, replaced, refused.
"""

import sys
from pathlib import Path

import actionlib
import genpy.dynamic
import rospy

text = Path(sys.argv[1]).read_text()
types = genpy.dynamic.generate_dynamic("actionlib_tutorials/FibonacciAction", text)
Action = types["actionlib_tutorials/FibonacciAction"]
Goal = types["actionlib_tutorials/FibonacciGoal"]

rospy.init_node("counter")
client = actionlib.SimpleActionClient("/fibonacci", Action)
other = actionlib.SimpleActionClient("/fibonacci", Action)
assert client.wait_for_server(rospy.Duration(60))
assert other.wait_for_server(rospy.Duration(60))


def report(each):
    assert each.wait_for_result(rospy.Duration(60))
    print(actionlib.TerminalState.to_string(each.get_state()), list(each.get_result().sequence), flush=True)


feedback = []
client.send_goal(Goal(order=3), feedback_cb=lambda message: feedback.append(list(message.sequence)))
report(client)
print("feedback", feedback[0], flush=True)

first = []
client.send_goal(Goal(order=19), feedback_cb=lambda message: first or first.append(client.cancel_goal()))
report(client)

client.send_goal(Goal(order=19), feedback_cb=lambda _: other.gh or other.send_goal(Goal(order=0)))
report(client)
report(other)
print(other.get_goal_status_text(), flush=True)
