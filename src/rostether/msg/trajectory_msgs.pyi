# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import geometry_msgs, std_msgs
from rostether.serde.values import Message

class JointTrajectory(Message):
    header: std_msgs.Header
    joint_names: list[str]
    points: list[JointTrajectoryPoint]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., joint_names: Sequence[str] = ..., points: Sequence[JointTrajectoryPoint | Mapping[str, Any]] = ...) -> None: ...

class JointTrajectoryPoint(Message):
    positions: list[float]
    velocities: list[float]
    accelerations: list[float]
    effort: list[float]
    time_from_start: rostime.Duration
    def __init__(self, *, positions: Sequence[float] = ..., velocities: Sequence[float] = ..., accelerations: Sequence[float] = ..., effort: Sequence[float] = ..., time_from_start: rostime.Duration | float = ...) -> None: ...

class MultiDOFJointTrajectory(Message):
    header: std_msgs.Header
    joint_names: list[str]
    points: list[MultiDOFJointTrajectoryPoint]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., joint_names: Sequence[str] = ..., points: Sequence[MultiDOFJointTrajectoryPoint | Mapping[str, Any]] = ...) -> None: ...

class MultiDOFJointTrajectoryPoint(Message):
    transforms: list[geometry_msgs.Transform]
    velocities: list[geometry_msgs.Twist]
    accelerations: list[geometry_msgs.Twist]
    time_from_start: rostime.Duration
    def __init__(self, *, transforms: Sequence[geometry_msgs.Transform | Mapping[str, Any]] = ..., velocities: Sequence[geometry_msgs.Twist | Mapping[str, Any]] = ..., accelerations: Sequence[geometry_msgs.Twist | Mapping[str, Any]] = ..., time_from_start: rostime.Duration | float = ...) -> None: ...
