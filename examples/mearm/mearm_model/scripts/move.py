#!/usr/bin/env python3
"""robot_joint_mover: publishes the positions of the joints, ten times a second.

Publishes   joint_states         sensor_msgs/JointState
Serves      select_position_set  mearm_model/MoveJoints, one of the sets below the parameter position_sets
"""

import contextlib
import math

import rospy
from mearm_model.srv import MoveJoints, MoveJointsResponse
from sensor_msgs.msg import JointState

JOINT_NAMES = ["joint_0", "joint_1", "joint_2", "joint_3"]
RATE_HZ = 10


class JointMover:
    """Holds the chosen joint positions, in radians."""

    def __init__(self):
        self.positions = [0.0] * len(JOINT_NAMES)
        self.publisher = rospy.Publisher("joint_states", JointState, queue_size=10)
        self.service = rospy.Service("select_position_set", MoveJoints, self.select_position_set)

    def select_position_set(self, request):
        """Use a position set; log the name of a set that does not exist or does not fit, and refuse it."""
        sets = rospy.get_param("position_sets", {})
        if request.set_name not in sets:
            known = ", ".join(sorted(sets))
            rospy.logwarn("Position set %s not found; there are: %s", request.set_name, known)
            return MoveJointsResponse(success=False)
        problem = self.explain_misfit(sets[request.set_name])
        if problem:
            rospy.logwarn("Position set %s is refused: %s", request.set_name, problem)
            return MoveJointsResponse(success=False)
        self.positions = [float(value) for value in sets[request.set_name]]
        return MoveJointsResponse(success=True)

    @staticmethod
    def explain_misfit(positions):
        """Return why these cannot be positions of the arm's joints, or an empty text."""
        if not isinstance(positions, list):
            return "it is not a list"
        if len(positions) != len(JOINT_NAMES):
            return f"it has {len(positions)} values, but the arm has {len(JOINT_NAMES)} joints"
        for value in positions:
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if not is_number or not math.isfinite(value):
                return f"{value!r} is not an angle in radians"
        return ""

    def run(self):
        """Publish until the node is shut down."""
        rate = rospy.Rate(RATE_HZ)
        while not rospy.is_shutdown():
            state = JointState(name=JOINT_NAMES, position=self.positions)
            state.header.stamp = rospy.Time.now()
            self.publisher.publish(state)
            rate.sleep()


if __name__ == "__main__":
    rospy.init_node("robot_joint_mover")
    with contextlib.suppress(rospy.ROSInterruptException):
        JointMover().run()
