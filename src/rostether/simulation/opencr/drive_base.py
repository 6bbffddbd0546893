"""A robot with two driven wheels: its pose from two simulated servos, and the values of its IMU."""

from __future__ import annotations

import math
from collections.abc import Callable

from rostether.simulation.dynamixel.servo import WheelMotor
from rostether.simulation.dynamixel.servo_bus import ServoBus
from rostether.simulation.motion import GRAVITY, Vector

# The dimensions of a TurtleBot3 Burger.
WHEEL_RADIUS_M = 0.033
WHEEL_SEPARATION_M = 0.160
LEFT_ID, RIGHT_ID = 1, 2
# The field of the simulated Earth, in tesla.
NORTH_T, UP_T = 20e-6, -44e-6
# The path during a step this short is nearly an arc, even while the wheels change their speed.
_STEP_S = 0.005
# After a long pause the steps are longer, so that computing them takes at most 20 ms.
_MAX_STEPS = 200


class DriveBase(ServoBus):
    """Two servos on a bus, and the robot's pose, without slip.

    At the start, x points forward and y to the left; the heading is counterclockwise.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__((LEFT_ID, RIGHT_ID), clock)
        self.x_m = 0.0
        self.y_m = 0.0
        self.heading_rad = 0.0
        self._advanced_s = clock()

    @property
    def speed_m_s(self) -> float:
        """The speed forward."""
        left, right = self._motors()
        return (left.speed_rad_s + right.speed_rad_s) / 2 * WHEEL_RADIUS_M

    @property
    def turn_rate_rad_s(self) -> float:
        """How fast it turns to the left."""
        left, right = self._motors()
        return (right.speed_rad_s - left.speed_rad_s) * WHEEL_RADIUS_M / WHEEL_SEPARATION_M

    def advance(self) -> None:
        """Move up to the present time."""
        now_s = self._clock()
        span_s = now_s - self._advanced_s
        steps = max(1, min(_MAX_STEPS, math.ceil(span_s / _STEP_S)))
        for step in range(1, steps + 1):
            self._step(self._advanced_s + span_s * step / steps)
        self._advanced_s = now_s

    def imu_values(self) -> tuple[Vector, Vector, Vector]:
        """Return turn rate (rad/s), acceleration (m/s²) and magnetic field (T), in the robot's axes."""
        turn_rate, speed = self.turn_rate_rad_s, self.speed_m_s
        acceleration_m_s2 = (
            sum(motor.current_acceleration_rad_s2 for motor in self._motors()) / 2 * WHEEL_RADIUS_M
        )
        return (
            Vector(0.0, 0.0, turn_rate),
            Vector(acceleration_m_s2, speed * turn_rate, GRAVITY),
            Vector(NORTH_T * math.cos(self.heading_rad), -NORTH_T * math.sin(self.heading_rad), UP_T),
        )

    def _step(self, now_s: float) -> None:
        left, right = self._motors()
        before = left.angle_rad, right.angle_rad
        for servo in self.servos.values():
            servo.advance(now_s)
        left_m = (left.angle_rad - before[0]) * WHEEL_RADIUS_M
        right_m = (right.angle_rad - before[1]) * WHEEL_RADIUS_M
        turn_rad = (right_m - left_m) / WHEEL_SEPARATION_M
        # The distance is the chord of the arc that the robot drives.
        chord_per_arc = 1.0 if abs(turn_rad) < 1e-9 else math.sin(turn_rad / 2) / (turn_rad / 2)
        distance_m = (left_m + right_m) / 2 * chord_per_arc
        self.x_m += distance_m * math.cos(self.heading_rad + turn_rad / 2)
        self.y_m += distance_m * math.sin(self.heading_rad + turn_rad / 2)
        self.heading_rad = math.remainder(self.heading_rad + turn_rad, math.tau)

    def _motors(self) -> tuple[WheelMotor, WheelMotor]:
        return self.servos[LEFT_ID].motor, self.servos[RIGHT_ID].motor
