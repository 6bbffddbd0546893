"""An HC-SR04 and the obstacle that moves before it."""

from __future__ import annotations

from math import pi, sin
from random import Random

# The sensor's data sheet: 2 cm to 4 m, a cone of 15 degrees, about 3 mm of scatter.
MIN_RANGE = 0.02
MAX_RANGE = 4.0
FIELD_OF_VIEW = 0.26
_SCATTER = 0.003
# Sound at 20 degrees Celsius; sketches count whole microseconds of its way there and back.
_SOUND_SPEED = 343.0
_TICK_S = 1e-6
# A soft or slanted thing swallows the echo now and then; the sketch then times out and reports the maximum.
_LOST_ECHO_PROBABILITY = 0.01


class Ultrasound:
    """Simulates the distance in metres to a person who walks to and fro; noise from `rng`."""

    def __init__(self, rng: Random) -> None:
        self._rng = rng

    def true_distance(self, time_s: float) -> float:
        """Return where the obstacle is: between 0.25 m and 2.75 m, never faster than 1 m/s."""
        return 1.5 + 0.9 * sin(2 * pi * time_s / 11.0) + 0.35 * sin(2 * pi * time_s / 4.7)

    def measure(self, time_s: float) -> float:
        """Return one reading, from MIN_RANGE to MAX_RANGE."""
        if self._rng.random() < _LOST_ECHO_PROBABILITY:
            return MAX_RANGE
        scattered = self.true_distance(time_s) + self._rng.gauss(0.0, _SCATTER)
        ticks = round(2.0 * scattered / _SOUND_SPEED / _TICK_S)
        return min(max(ticks * _TICK_S * _SOUND_SPEED / 2.0, MIN_RANGE), MAX_RANGE)
