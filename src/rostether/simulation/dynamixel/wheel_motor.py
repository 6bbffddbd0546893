"""The movement of a servo in velocity mode: its speed follows the goal with a limited acceleration."""

from __future__ import annotations

import math

# An XL430 without load is at 6 rad/s within 0.1 s.
ACCELERATION_RAD_S2 = 60.0


class WheelMotor:
    """One wheel: `angle_rad` and `speed_rad_s` at the time of the last `advance`."""

    def __init__(self, now_s: float) -> None:
        self.angle_rad = 0.0
        self.speed_rad_s = 0.0
        self.goal_rad_s = 0.0
        self.acceleration_rad_s2 = ACCELERATION_RAD_S2
        self._time_s = now_s

    @property
    def acceleration_now_rad_s2(self) -> float:
        """How fast its speed changes; 0 at the goal."""
        missing = self.goal_rad_s - self.speed_rad_s
        return math.copysign(self.acceleration_rad_s2, missing) if missing else 0.0

    @property
    def effort(self) -> float:
        """The part of its torque that accelerates the wheel, -1 to 1."""
        return max(-1.0, min(1.0, (self.goal_rad_s - self.speed_rad_s) / self.acceleration_rad_s2 / 0.1))

    def advance(self, now_s: float) -> None:
        """Move until `now_s`. Exact for any step, so that a busy machine changes nothing."""
        step_s = max(0.0, now_s - self._time_s)
        self._time_s = max(self._time_s, now_s)
        missing = self.goal_rad_s - self.speed_rad_s
        ramp_s = min(step_s, abs(missing) / self.acceleration_rad_s2)
        reached = self.speed_rad_s + self.acceleration_now_rad_s2 * ramp_s
        if ramp_s < step_s:
            reached = self.goal_rad_s
        self.angle_rad += (self.speed_rad_s + reached) / 2 * ramp_s + reached * (step_s - ramp_s)
        self.speed_rad_s = reached
