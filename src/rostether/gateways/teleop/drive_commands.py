"""Limits the speed and acceleration of messages that drive a robot, and makes stops; without I/O."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import attrgetter

from msgspec import Struct

from rostether.errors import SerializationError
from rostether.serde.values import Message

LINEAR, ANGULAR, SPEED = "linear", "angular", "speed"


class DriveLimits(Struct, frozen=True):
    """The limits of published commands; each is also a parameter of the node.

    `max_linear` is in m/s, `max_angular` in rad/s, and `max_speed` in the unit of the command. Each
    acceleration is in the unit of its speed per second. The defaults are a walking pace.
    """

    max_linear: float = 1.0
    max_angular: float = 2.0
    max_speed: float = 1.0
    max_linear_acceleration: float = 2.0
    max_angular_acceleration: float = 6.0
    max_speed_acceleration: float = 2.0

    @classmethod
    def of(cls, values: Mapping[str, object]) -> DriveLimits:
        """Read parameters; those that are missing or negative keep their default."""
        known = {
            each: float(value)
            for each in cls.__struct_fields__
            if isinstance(value := values.get(each), int | float)
            and not isinstance(value, bool)
            and value >= 0
        }
        return cls(**known)

    def limits_of(self, kind: str) -> tuple[float, float]:
        """Return the limits of a kind of value: its maximum, and its maximum change per second."""
        return getattr(self, f"max_{kind}"), getattr(self, f"max_{kind}_acceleration")


# The values of each type that move the robot. The values of one vector are limited together, so that it
# keeps its direction.
_XYZ = ("x", "y", "z")
_VECTORS: Mapping[str, Sequence[tuple[str, tuple[str, ...]]]] = {
    "geometry_msgs/Twist": [(kind, tuple(f"{kind}.{axis}" for axis in _XYZ)) for kind in (LINEAR, ANGULAR)],
    "geometry_msgs/TwistStamped": [
        (kind, tuple(f"twist.{kind}.{axis}" for axis in _XYZ)) for kind in (LINEAR, ANGULAR)
    ],
    "arduino_control/ArduinoControl": [(SPEED, ("speed",))],
}
DRIVE_TYPES = tuple(_VECTORS)

# Between two commands, the speed grows for at most this time: the first command after a pause must not jump.
_MAX_STEP_S = 0.1


class DriveCommands:
    """Limits the commands of one topic, one after another."""

    def __init__(self, type_name: str, limits: DriveLimits) -> None:
        self.limits = limits
        self._vectors = _VECTORS[type_name]
        self._published = [[0.0] * len(paths) for _, paths in self._vectors]
        self._published_s = -math.inf

    def is_stop(self, message: Message) -> bool:
        """Return whether a message is a stop."""
        return all(_read(message, path) == 0 for _, paths in self._vectors for path in paths)

    def limit(self, message: Message, now_s: float) -> bool:
        """Limit a message in place; return whether it is a stop. Raises SerializationError.

        Acceleration is limited, deceleration is not: a slower command and a stop take effect immediately.
        """
        wanted = [[_read(message, path) for path in paths] for _, paths in self._vectors]
        if not all(math.isfinite(value) for vector in wanted for value in vector):
            raise SerializationError("a command must have finite values, not NaN or infinity")
        step_s = min(max(now_s - self._published_s, 0.0), _MAX_STEP_S)
        for index, (kind, paths) in enumerate(self._vectors):
            max_length, acceleration = self.limits.limits_of(kind)
            length = math.hypot(*wanted[index])
            scale = max_length / length if length > max_length else 1.0
            before = self._published[index]
            after = [
                _approach(old, value * scale, acceleration * step_s)
                for old, value in zip(before, wanted[index], strict=True)
            ]
            self._published[index] = after
            for path, value in zip(paths, after, strict=True):
                _write(message, path, value)
        self._published_s = now_s
        return all(value == 0 for vector in self._published for value in vector)

    def stop(self, message: Message) -> None:
        """Change a message to a stop, in place."""
        for index, (_, paths) in enumerate(self._vectors):
            self._published[index] = [0.0] * len(paths)
            for path in paths:
                _write(message, path, 0.0)


def _approach(old: float, wanted: float, step: float) -> float:
    # A change of direction stops immediately, and then starts with at most one step.
    start = old if old * wanted > 0 else 0.0
    if abs(wanted) <= abs(start) + step:
        return wanted
    return math.copysign(abs(start) + step, wanted)


def _read(message: Message, path: str) -> float:
    return float(attrgetter(path)(message))


def _write(message: Message, path: str, value: float) -> None:
    parent, _, name = path.rpartition(".")
    setattr(attrgetter(parent)(message) if parent else message, name, value)
