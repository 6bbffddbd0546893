"""An HC-SR04 and an obstacle that moves in front of it."""

from __future__ import annotations

from math import isinf, pi, sin
from random import Random

# The sensor's data sheet: 2 cm to 4 m, a cone of 15 degrees, about 3 mm of scatter.
MIN_RANGE = 0.02
MAX_RANGE = 4.0
FIELD_OF_VIEW = 0.26
_SCATTER = 0.003
# The speed of sound at 20 °C; sketches measure the round trip in whole microseconds.
_SOUND_SPEED = 343.0
_TICK_S = 1e-6
# Soft or slanted objects sometimes absorb the echo; the sketch then times out and reports the maximum.
_LOST_ECHO_PROBABILITY = 0.002


class Obstacle:
    """A person who walks back and forth in front of the sensor, until `place` or `move` is called."""

    def __init__(self) -> None:
        self._placed_at: float | None = None

    def distance(self, time_s: float) -> float:
        """Return the distance in meters, inf if nothing is there.

        The walk is between 0.25 m and 2.75 m, never faster than 1 m/s.
        """
        if self._placed_at is not None:
            return self._placed_at
        return 1.5 + 0.9 * sin(2 * pi * time_s / 11.0) + 0.35 * sin(2 * pi * time_s / 4.7)

    def move(self, by_m: float, time_s: float) -> None:
        """Move it from its position at `time_s`; it stays there, within the sensor's range."""
        self.place(min(max(self.distance(time_s) + by_m, MIN_RANGE), MAX_RANGE))

    def place(self, distance_m: float) -> None:
        """Put it at a distance, where it stays; inf removes it."""
        self._placed_at = distance_m


class Ultrasound:
    """Simulates readings of the distance to an obstacle in meters; `rng` makes their noise."""

    def __init__(self, rng: Random, obstacle: Obstacle) -> None:
        self._rng = rng
        self._obstacle = obstacle

    def measure(self, time_s: float) -> float:
        """Return one reading, from MIN_RANGE to MAX_RANGE."""
        if self._rng.random() < _LOST_ECHO_PROBABILITY:
            return MAX_RANGE
        distance = self._obstacle.distance(time_s)
        if isinf(distance):
            return MAX_RANGE
        scattered = distance + self._rng.gauss(0.0, _SCATTER)
        ticks = round(2.0 * scattered / _SOUND_SPEED / _TICK_S)
        return min(max(ticks * _TICK_S * _SOUND_SPEED / 2.0, MIN_RANGE), MAX_RANGE)
