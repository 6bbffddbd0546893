"""Converts joint positions to transforms, like robot_state_publisher. It uses no clock and no graph.

Fixed joints have fixed transforms. So do planar joints, because one number cannot describe their position.
Floating joints have none here, because the localization publishes them. Moving joints are published as soon
as a state contains them, but at most at `publish_frequency_hz`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from msgspec import Struct

from rostether.robot.robot_model import ONE_DEGREE_OF_FREEDOM, Joint, JointType, RobotModel, mimic_chain
from rostether.robot.transform import (
    StampedTransform,
    Transform,
    Vector,
    matrix_from_axis_angle,
    matrix_from_quaternion,
    matrix_product,
    matrix_times_vector,
    quaternion_from_matrix,
)
from rostether.rostime import NS_PER_S

# A state older than this is probably stamped by another clock.
OLD_STATE_NS = 30 * NS_PER_S


class RobotStateSettings(Struct, frozen=True):
    """The parameters of robot_state_publisher, with its defaults."""

    publish_frequency_hz: float = 50.0
    use_tf_static: bool = True
    ignore_timestamp: bool = False
    tf_prefix: str = ""

    @property
    def interval_ns(self) -> int:
        """The shortest time between two transforms of one joint."""
        return round(NS_PER_S / max(self.publish_frequency_hz, 1.0))


class RobotState:
    """Converts a robot's joint states to transforms; `problem` describes what is wrong with the last state.

    Raises RobotModelError if joints mimic each other in a cycle.
    """

    def __init__(self, model: RobotModel, settings: RobotStateSettings | None = None) -> None:
        self.settings = RobotStateSettings() if settings is None else settings
        self._model = model
        self._fixed: list[Joint] = []
        self._moving: dict[str, Joint] = {}
        for name, joint in sorted(model.joints.items()):
            if joint.type in ONE_DEGREE_OF_FREEDOM:
                self._moving[name] = joint
            elif joint.type is not JointType.FLOATING:
                self._fixed.append(joint)
        for name in model.mimics:
            mimic_chain(model.mimics, name)
        self._published_ns: dict[str, int] = {}
        self._last_call_ns = 0
        self.problem = ""

    def fixed_transforms(self, stamp_ns: int) -> list[StampedTransform]:
        """Return the transforms of all joints that cannot move."""
        return [self._stamped(joint, 0.0, stamp_ns) for joint in self._fixed]

    def moving_transforms(
        self, names: Sequence[str], positions: Sequence[float], stamp_ns: int, now_ns: int
    ) -> list[StampedTransform]:
        """Return the transforms for a joint state, sorted by joint, with those of mimicking joints.

        Returns none if the last ones are too recent or the lists have different lengths. Sets `problem` to
        one line about an invalid state, or to an empty string.
        """
        self.problem = self._defect(names, positions, stamp_ns, now_ns)
        if len(names) != len(positions):
            return []
        if self._last_call_ns > now_ns:
            self._published_ns.clear()
        self._last_call_ns = now_ns
        # If a joint occurs twice, the first value counts. Unknown names are not stored: a peer could send any
        # number of them.
        values = reversed(list(zip(names, positions, strict=True)))
        known = {name: each for name, each in values if name in self._moving and math.isfinite(each)}
        last_ns = min((self._published_ns.get(name, 0) for name in known), default=now_ns)
        if not self.settings.ignore_timestamp and stamp_ns < min(last_ns, now_ns) + self.settings.interval_ns:
            return []
        self._published_ns.update(dict.fromkeys(known, stamp_ns))
        complete = with_mimics(self._model, known)
        return [
            self._stamped(joint, complete[name], stamp_ns)
            for name, joint in self._moving.items()
            if math.isfinite(complete.get(name, math.nan))
        ]

    def _defect(self, names: Sequence[str], positions: Sequence[float], stamp_ns: int, now_ns: int) -> str:
        if len(names) != len(positions):
            if not positions:
                return f"ignored a JointState without positions, with joint {names[0]!r}"
            return f"ignored a JointState with {len(names)} names and {len(positions)} positions"
        if self._last_call_ns > now_ns:
            return "time went backwards, probably because the clock was reset; publishing all joints again"
        if stamp_ns + OLD_STATE_NS < now_ns:
            return f"received a JointState that is {(now_ns - stamp_ns) / NS_PER_S:.3f} s old"
        for name, position in zip(names, positions, strict=True):
            if not math.isfinite(position):
                return f"ignored joint {name!r} in a JointState: its position is {position}"
        unknown = [name for name in names if name not in self._model.joints]
        return f"a JointState contains joint {unknown[0]!r}, which the robot does not have" if unknown else ""

    def _stamped(self, joint: Joint, position: float, stamp_ns: int) -> StampedTransform:
        prefix = self.settings.tf_prefix
        return StampedTransform(
            prefixed(prefix, joint.parent),
            prefixed(prefix, joint.child),
            stamp_ns,
            joint_transform(joint, position),
        )


def prefixed(prefix: str, frame: str) -> str:
    """Return a frame's name with tf_prefix; from a name that starts with `/`, only the slash is removed."""
    if frame.startswith("/"):
        return frame[1:]
    return f"{prefix.removeprefix('/')}/{frame}" if prefix else frame


def joint_transform(joint: Joint, position: float = 0.0) -> Transform:
    """Return the transform from a joint's parent to its child, for a position in radians or meters."""
    rotation = matrix_from_quaternion(joint.origin.rotation)
    translation = joint.origin.translation
    if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
        axis = _unit(matrix_times_vector(rotation, joint.axis))
        rotation = matrix_product(matrix_from_axis_angle(axis, position), rotation)
    elif joint.type is JointType.PRISMATIC:
        x, y, z = _unit(matrix_times_vector(rotation, joint.axis))
        translation = (
            translation[0] + x * position,
            translation[1] + y * position,
            translation[2] + z * position,
        )
    return Transform(translation, quaternion_from_matrix(rotation))


def with_mimics(model: RobotModel, positions: Mapping[str, float]) -> dict[str, float]:
    """Return the positions, with those of the joints that mimic them, directly or indirectly.

    Raises RobotModelError if joints mimic each other in a cycle.
    """
    complete = dict(positions)
    mimics = model.mimics
    for name in mimics:
        if name not in complete:
            factor, offset, leader = mimic_chain(mimics, name, positions)
            if leader in positions:
                complete[name] = factor * positions[leader] + offset
    return complete


def _unit(vector: Vector) -> Vector:
    # Divides by the largest part like KDL: where two parts of a quaternion differ only by rounding, the last
    # bit determines its sign.
    x, y, z = vector
    if abs(x) >= abs(y) and abs(x) >= abs(z):
        length = abs(x) * math.sqrt(1 + (y / x) ** 2 + (z / x) ** 2)
    elif abs(y) > abs(z) and abs(y) > abs(x):
        length = abs(y) * math.sqrt(1 + (x / y) ** 2 + (z / y) ** 2)
    else:
        length = abs(z) * math.sqrt(1 + (x / z) ** 2 + (y / z) ** 2)
    return x / length, y / length, z / length
