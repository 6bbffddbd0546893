"""The pose of a robot with two simulated servos."""

from __future__ import annotations

import math

import pytest

from rostether.simulation.dynamixel.control_table import BY_NAME
from rostether.simulation.dynamixel.servo import RAD_S_PER_UNIT
from rostether.simulation.opencr.drive_base import WHEEL_RADIUS_M, WHEEL_SEPARATION_M, DriveBase


class Drive:
    """A robot whose clock the test sets."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.base = DriveBase(lambda: self.now_s)

    def command(self, left: int, right: int) -> None:
        """Set the goal velocities, in units of the servos."""
        for servo_id, units in ((1, left), (2, right)):
            servo = self.base.servos[servo_id]
            for name, value in (("operating_mode", 1), ("torque_enable", 1), ("goal_velocity", units)):
                register = BY_NAME[name]
                if servo["torque_enable"] == 0 or name == "goal_velocity":
                    data = value.to_bytes(register.size, "little", signed=value < 0)
                    assert servo.write(register.address, data) == 0

    def wait(self, span_s: float) -> None:
        """Let time pass."""
        self.now_s += span_s
        self.base.advance()


def test_equal_speeds_drive_straight() -> None:
    drive = Drive()
    drive.command(100, 100)
    drive.wait(2)
    speed = 100 * RAD_S_PER_UNIT * WHEEL_RADIUS_M
    ramp_s = 100 * RAD_S_PER_UNIT / 60
    assert drive.base.speed_m_s == pytest.approx(speed)
    assert (drive.base.x_m, drive.base.y_m) == pytest.approx((speed * (2 - ramp_s / 2), 0))


def test_different_speeds_drive_a_circle() -> None:
    drive = Drive()
    drive.command(50, 100)
    radius = 150 / 50 * WHEEL_SEPARATION_M / 2
    for _ in range(20):
        drive.wait(0.1)
    # The wheels reach their speeds after different times, 40 ms apart.
    heading = drive.base.heading_rad
    assert drive.base.x_m == pytest.approx(radius * math.sin(heading), abs=0.003)
    assert drive.base.y_m == pytest.approx(radius * (1 - math.cos(heading)), abs=0.003)
    turn_rate, acceleration, field = drive.base.imu_values()
    assert turn_rate.z == pytest.approx(50 * RAD_S_PER_UNIT * WHEEL_RADIUS_M / WHEEL_SEPARATION_M)
    assert acceleration.y == pytest.approx(turn_rate.z**2 * radius)
    assert math.atan2(-field.y, field.x) == pytest.approx(heading)


def test_one_long_step_is_like_many_short_ones() -> None:
    places = []
    for steps in (1, 250):
        drive = Drive()
        drive.command(-200, 120)
        for _ in range(steps):
            drive.wait(1 / steps)
        places.append((drive.base.x_m, drive.base.y_m, drive.base.heading_rad))
    assert places[0] == pytest.approx(places[1], abs=1e-4)
