#!/usr/bin/env python3
"""mearm_controller: turns joint states into servo angles, and moves the servos to named poses.

Subscribes  joint_states       sensor_msgs/JointState, radians
            servo_angles       mearm_model/ServoAngles, the angles that the board holds
Publishes   servo_pose_server  mearm_model/ServoAngles, degrees
Serves      set_servo_pose     mearm_model/MoveArm, the id of a pose in the parameter servo_poses
Parameters  ~interpolation_steps (10), ~step_duration (0.05 s): how a pose is approached

A pose is held until the joint states change.
"""

import math
import threading

import rospy
from mearm_model.msg import ServoAngles
from mearm_model.srv import MoveArm, MoveArmResponse
from sensor_msgs.msg import JointState

JOINT_NAMES = ["joint_0", "joint_1", "joint_2", "joint_3"]
SERVO_NAMES = ["servo1", "servo2", "servo3", "servo4"]
MAX_DEGREES = 360


class Controller:
    """Decides which angles the servos get: those of the joints, or those of a pose."""

    def __init__(self):
        self.lock = threading.Lock()
        self.joint_angles = [0] * len(JOINT_NAMES)
        self.pose = None
        self.is_moving = False
        self.held_by_board = None
        self.steps = max(1, int(rospy.get_param("~interpolation_steps", 10)))
        self.step_duration = float(rospy.get_param("~step_duration", 0.05))
        self.publisher = rospy.Publisher("servo_pose_server", ServoAngles, queue_size=10)
        self.subscribers = [
            rospy.Subscriber("joint_states", JointState, self.handle_joint_states),
            rospy.Subscriber("servo_angles", ServoAngles, self.handle_servo_angles),
        ]
        self.service = rospy.Service("set_servo_pose", MoveArm, self.set_servo_pose)

    def handle_joint_states(self, states):
        """Publish the servo angles for these joint states; a joint that is not among them stays."""
        angles = list(self.joint_angles)
        for name, position in zip(states.name, states.position):
            if name not in JOINT_NAMES:
                continue
            degrees = math.degrees(position)
            if not abs(degrees) <= MAX_DEGREES:
                rospy.logwarn_throttle(5, f"{name} at {position} rad is outside the range of the servos")
                continue
            angles[JOINT_NAMES.index(name)] = round(degrees)
        with self.lock:
            if angles != self.joint_angles:
                self.joint_angles = angles
                self.pose = None
            if not self.is_moving:
                self.publish(self.joint_angles if self.pose is None else self.pose)

    def handle_servo_angles(self, angles):
        """Store the angles at which the board holds its servos."""
        self.held_by_board = [getattr(angles, name) for name in SERVO_NAMES]

    def set_servo_pose(self, request):
        """Move the servos to a pose in small steps, and answer when they have reached it."""
        goal = self.find_pose(request.position_id)
        if goal is None:
            return MoveArmResponse(success=False)
        with self.lock:
            if self.is_moving:
                rospy.logwarn("Servo pose %d is refused: the arm is still moving", request.position_id)
                return MoveArmResponse(success=False)
            self.is_moving = True
            start = self.held_by_board or self.pose or self.joint_angles
        try:
            for step in range(1, self.steps + 1):
                self.publish([a + round((b - a) * step / self.steps) for a, b in zip(start, goal)])
                rospy.sleep(self.step_duration)
        finally:
            with self.lock:
                self.pose = goal
                self.is_moving = False
        return MoveArmResponse(success=True)

    @staticmethod
    def find_pose(position_id):
        """Return the angles of a pose; None if it does not exist or is not valid."""
        poses = rospy.get_param("servo_poses", [])
        if not 0 <= position_id < len(poses):
            rospy.logwarn("Servo pose %d not found; there are %d, from 0", position_id, len(poses))
            return None
        angles = [poses[position_id].get(name) for name in SERVO_NAMES]
        if not all(isinstance(angle, int) and 0 <= angle <= 180 for angle in angles):
            rospy.logwarn(
                "Servo pose %d is refused: it needs servo1 to servo4, 0 to 180 degrees", position_id
            )
            return None
        return angles

    def publish(self, angles):
        """Send angles to the board."""
        self.publisher.publish(*angles)


if __name__ == "__main__":
    rospy.init_node("mearm_controller")
    controller = Controller()
    rospy.spin()
