"""The pose of every link of a robot, computed from its joints."""

from __future__ import annotations

from collections.abc import Mapping

from rostether.robot.robot_model import RobotModel
from rostether.robot.robot_state import joint_transform, with_mimics
from rostether.robot.transform import Transform


def forward_kinematics(model: RobotModel, positions: Mapping[str, float]) -> dict[str, Transform]:
    """Return the pose of every link in the frame of the root link; joints without a position are at zero."""
    complete = with_mimics(model, positions)
    poses = {model.root: Transform()}
    waiting = [model.root]
    while waiting:
        link = waiting.pop()
        for joint in model.joints_below(link):
            poses[joint.child] = poses[link] @ joint_transform(joint, complete.get(joint.name, 0.0))
            waiting.append(joint.child)
    return poses
