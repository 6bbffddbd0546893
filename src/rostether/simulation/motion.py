"""The motion of the virtual robot: a circle on the floor, swaying, and its sensor values.

All values are functions of time only, so that pose, turn rate and acceleration are consistent.
Axes as in REP 103: x forward, y left, z up; meters, radians, seconds.
"""

from __future__ import annotations

from math import cos, pi, sin
from typing import NamedTuple

from msgspec import Struct

GRAVITY = 9.80665


class Vector(NamedTuple):
    """A vector in the axes of its context."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """A rotation, of length one."""

    x: float
    y: float
    z: float
    w: float


class Pose(Struct, frozen=True):
    """Position and orientation of the robot in the frame of its start."""

    position: Vector
    orientation: Quaternion


class ImuValues(Struct, frozen=True):
    """The values of an ideal inertial sensor, in the robot's axes."""

    turn_rate: Vector
    acceleration: Vector


class CircleDrive(Struct, frozen=True):
    """Drives a circle in `lap_s`, and rolls and pitches by up to `sway` radians."""

    radius: float = 1.0
    lap_s: float = 20.0
    sway: float = 0.05
    sway_hz: float = 0.5

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time."""
        yaw = self._yaw_rate * time_s
        roll, pitch = self._sway_at(time_s)[:2]
        position = Vector(self.radius * sin(yaw), self.radius * (1.0 - cos(yaw)), 0.0)
        return Pose(position, _quaternion(roll, pitch, yaw))

    def imu_values(self, time_s: float) -> ImuValues:
        """Return turn rate and acceleration at a time; gravity appears as an upward acceleration."""
        roll, pitch, roll_rate, pitch_rate = self._sway_at(time_s)
        yaw_rate = self._yaw_rate
        turn_rate = Vector(
            roll_rate - yaw_rate * sin(pitch),
            pitch_rate * cos(roll) + yaw_rate * cos(pitch) * sin(roll),
            -pitch_rate * sin(roll) + yaw_rate * cos(pitch) * cos(roll),
        )
        inward = self.radius * yaw_rate**2
        acceleration = Vector(
            -GRAVITY * sin(pitch),
            inward * cos(roll) + GRAVITY * sin(roll) * cos(pitch),
            -inward * sin(roll) + GRAVITY * cos(roll) * cos(pitch),
        )
        return ImuValues(turn_rate, acceleration)

    @property
    def _yaw_rate(self) -> float:
        return 2.0 * pi / self.lap_s

    def _sway_at(self, time_s: float) -> tuple[float, float, float, float]:
        """Return roll, pitch and their rates."""
        rate = 2.0 * pi * self.sway_hz
        phase = rate * time_s
        return (
            self.sway * sin(phase),
            self.sway * cos(phase),
            self.sway * rate * cos(phase),
            -self.sway * rate * sin(phase),
        )


def _quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation by yaw about z, then pitch about y, then roll about x."""
    cos_roll, sin_roll = cos(roll / 2), sin(roll / 2)
    cos_pitch, sin_pitch = cos(pitch / 2), sin(pitch / 2)
    cos_yaw, sin_yaw = cos(yaw / 2), sin(yaw / 2)
    return Quaternion(
        sin_roll * cos_pitch * cos_yaw - cos_roll * sin_pitch * sin_yaw,
        cos_roll * sin_pitch * cos_yaw + sin_roll * cos_pitch * sin_yaw,
        cos_roll * cos_pitch * sin_yaw - sin_roll * sin_pitch * cos_yaw,
        cos_roll * cos_pitch * cos_yaw + sin_roll * sin_pitch * sin_yaw,
    )
