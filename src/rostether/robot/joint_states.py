"""The joint positions of joint_state_publisher: zeros, limits, sources, mimicking joints.

This module uses no clock and no graph.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from msgspec import Struct, field

from rostether.errors import RobotModelError
from rostether.robot.robot_model import (
    ONE_DEGREE_OF_FREEDOM,
    Joint,
    JointType,
    Mimic,
    RobotModel,
    mimic_chain,
)


class JointStateSettings(Struct, frozen=True):
    """The parameters of joint_state_publisher, with its defaults; `step` moves each joint by `delta`."""

    zeros: Mapping[str, float] = field(default_factory=dict)
    dependent_joints: Mapping[str, Mimic] = field(default_factory=dict)
    use_mimic_tags: bool = True
    use_smallest_joint_limits: bool = True
    publish_default_positions: bool = True
    publish_default_velocities: bool = False
    publish_default_efforts: bool = False
    delta: float = 0.0


class FreeJoint(Struct):
    """One joint that can be set, in radians or meters; values that are None are not published.

    `is_forward` is the direction of the next step.
    """

    lower: float
    upper: float
    zero: float
    is_continuous: bool
    position: float | None = None
    velocity: float | None = None
    effort: float | None = None
    is_forward: bool = True


class JointStateValues(Struct, frozen=True):
    """The fields of a sensor_msgs/JointState; unknown lists are empty."""

    name: list[str]
    position: list[float]
    velocity: list[float]
    effort: list[float]


class JointStates:
    """The joints of one robot; `free` are those that can be set.

    Raises RobotModelError if joints mimic each other in a cycle, or mimic one that cannot be set.
    """

    def __init__(self, model: RobotModel, settings: JointStateSettings | None = None) -> None:
        self.settings = settings = JointStateSettings() if settings is None else settings
        self.free: dict[str, FreeJoint] = {}
        self._dependent = dict(settings.dependent_joints)
        self._order: list[str] = []
        for name, joint in model.joints.items():
            if joint.type not in ONE_DEGREE_OF_FREEDOM:
                continue
            self._order.append(name)
            if settings.use_mimic_tags and joint.mimic is not None:
                self._dependent[name] = joint.mimic
            elif name not in self._dependent:
                self.free[name] = self._free_joint(name, joint)
        self._leaders = {name: self._leader(name) for name in self._order if name not in self.free}

    def receive(
        self,
        names: Sequence[str],
        positions: Sequence[float] = (),
        velocities: Sequence[float] = (),
        efforts: Sequence[float] = (),
    ) -> None:
        """Store the values of a source for known joints; a short list sets only the first names."""
        for values, attribute in ((positions, "position"), (velocities, "velocity"), (efforts, "effort")):
            for name, value in zip(names, values, strict=False):
                if name in self.free:
                    setattr(self.free[name], attribute, value)

    def set_position(self, name: str, position: float) -> None:
        """Set a free joint, within its limits."""
        joint = self.free[name]
        joint.position = min(max(position, joint.lower), joint.upper)

    def center(self) -> None:
        """Set all free joints to their zeros."""
        for joint in self.free.values():
            joint.position = joint.zero

    def step(self) -> None:
        """Move all free joints by `delta`, back and forth between their limits; continuous joints rotate."""
        delta = self.settings.delta
        if delta <= 0:
            return
        for joint in self.free.values():
            position = (joint.position or 0.0) + (delta if joint.is_forward else -delta)
            if joint.is_forward and position > joint.upper:
                position = joint.lower if joint.is_continuous else joint.upper
                joint.is_forward = joint.is_continuous
            elif not joint.is_forward and position < joint.lower:
                position, joint.is_forward = joint.lower, True
            joint.position = position

    def values(self) -> JointStateValues:
        """Return the state of all joints with one degree of freedom, in the order of the description."""
        free = self.free.values()
        has_position = bool(self._leaders) or any(each.position is not None for each in free)
        has_velocity = any(each.velocity is not None for each in free)
        has_effort = any(each.effort is not None for each in free)
        values = JointStateValues(list(self._order), [], [], [])
        for name in self._order:
            factor, offset, leader = self._leaders.get(name, (1.0, 0.0, name))
            joint = self.free[leader]
            if has_position:
                values.position.append(0.0 if joint.position is None else joint.position * factor + offset)
            if has_velocity:
                values.velocity.append(0.0 if joint.velocity is None else joint.velocity * factor)
            if has_effort:
                values.effort.append(0.0 if joint.effort is None else joint.effort)
        return values

    def _free_joint(self, name: str, joint: Joint) -> FreeJoint:
        settings, limits = self.settings, joint.limits
        if joint.type is JointType.CONTINUOUS or limits is None:
            lower, upper = -math.pi, math.pi
        else:
            lower, upper = limits.lower, limits.upper
        if settings.use_smallest_joint_limits and limits is not None:
            lower = lower if limits.soft_lower is None else max(lower, limits.soft_lower)
            upper = upper if limits.soft_upper is None else min(upper, limits.soft_upper)
        zero = float(settings.zeros.get(name) or 0.0)
        if not zero and (lower > 0 or upper < 0):
            zero = (lower + upper) / 2
        return FreeJoint(
            lower,
            upper,
            zero,
            joint.type is JointType.CONTINUOUS,
            zero if settings.publish_default_positions else None,
            0.0 if settings.publish_default_velocities else None,
            0.0 if settings.publish_default_efforts else None,
        )

    def _leader(self, name: str) -> tuple[float, float, str]:
        factor, offset, leader = mimic_chain(self._dependent, name)
        if leader not in self.free:
            raise RobotModelError(
                f"joint {name!r} mimics {leader!r}, which is not a movable joint of the robot; "
                "correct its mimic or dependent_joints"
            )
        return factor, offset, leader
