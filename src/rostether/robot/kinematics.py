"""The transforms of joints at given positions.

The computation is the same as in KDL, with rotation matrices, so the results are equal to those of
robot_state_publisher.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from rostether.errors import RobotModelError
from rostether.robot.robot_model import Joint, JointType, RobotModel
from rostether.robot.transform import (
    Transform,
    Vector,
    matrix_from_axis_angle,
    matrix_from_quaternion,
    matrix_product,
    matrix_times_vector,
    quaternion_from_matrix,
)


def joint_transform(joint: Joint, position: float = 0.0) -> Transform:
    """Return the transform from a joint's parent to its child, for a position in radians or metres."""
    turn = matrix_from_quaternion(joint.origin.rotation)
    place = joint.origin.translation
    if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
        axis = _unit(matrix_times_vector(turn, joint.axis))
        turn = matrix_product(matrix_from_axis_angle(axis, position), turn)
    elif joint.type is JointType.PRISMATIC:
        x, y, z = _unit(matrix_times_vector(turn, joint.axis))
        place = (place[0] + x * position, place[1] + y * position, place[2] + z * position)
    return Transform(place, quaternion_from_matrix(turn))


def with_mimics(model: RobotModel, positions: Mapping[str, float]) -> dict[str, float]:
    """Return the positions, with those of all joints that mimic them, directly or indirectly.

    Raises RobotModelError if joints mimic each other in a circle.
    """
    complete = dict(positions)
    for name, joint in model.joints.items():
        if joint.mimic is not None and name not in complete:
            factor, offset, leader = mimic_chain(model, joint, positions)
            if leader in positions:
                complete[name] = factor * positions[leader] + offset
            else:
                complete[name] = offset
    return complete


def mimic_chain(
    model: RobotModel, joint: Joint, given: Mapping[str, object] | None = None
) -> tuple[float, float, str]:
    """Return factor, offset and name of the joint at the end of a chain of mimicking joints.

    Joints in `given` end the chain. Raises RobotModelError for a circle.
    """
    factor, offset, passed = 1.0, 0.0, [joint.name]
    current: Joint | None = joint
    while current is not None and current.mimic is not None:
        offset += factor * current.mimic.offset
        factor *= current.mimic.multiplier
        leader = current.mimic.joint
        if leader in passed:
            raise RobotModelError(f"joints mimic each other in a circle: {', '.join([*passed, leader])}")
        passed.append(leader)
        current = None if given is not None and leader in given else model.joints.get(leader)
    return factor, offset, passed[-1]


def _unit(vector: Vector) -> Vector:
    # Chooses the largest part like KDL: if two parts of a quaternion differ only by rounding, the last bit
    # decides its sign.
    x, y, z = vector
    if abs(x) >= abs(y) and abs(x) >= abs(z):
        length = abs(x) * math.sqrt(1 + (y / x) ** 2 + (z / x) ** 2)
    elif abs(y) > abs(z) and abs(y) > abs(x):
        length = abs(y) * math.sqrt(1 + (x / y) ** 2 + (z / y) ** 2)
    else:
        length = abs(z) * math.sqrt(1 + (x / z) ** 2 + (y / z) ** 2)
    return x / length, y / length, z / length
