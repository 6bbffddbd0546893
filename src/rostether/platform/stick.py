"""Converts a joystick's two axes to direction and speed: 0 degrees is forward, 90 right, 180 or -180 back."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

DEFAULT_DEADZONE = 0.1


@dataclass(frozen=True, slots=True)
class DriveCommand:
    """A direction in degrees and a speed; 1.0 is full speed."""

    direction_deg: float
    speed: float


Formula: TypeAlias = Callable[[float, float, float], DriveCommand]


def reference_command(left: float, forward: float, deadzone: float) -> DriveCommand:
    """Return the command that the reference node sends.

    The speed is 0 only if both axes are below the dead zone, and 1.414 in the corners. The angle is rounded
    to 32 bits, because the reference node uses 32-bit axes.
    """
    angle = _float32(_float32(math.atan2(-left, forward)) * 180)
    is_still = abs(left) < deadzone and abs(forward) < deadzone
    # The reference node's value of pi.
    return DriveCommand(angle / 3.14159265359, 0.0 if is_still else math.sqrt(forward**2 + left**2))


def radial_command(left: float, forward: float, deadzone: float) -> DriveCommand:
    """Return a command whose speed grows from 0 at the edge of a round dead zone to 1, in every direction."""
    distance = math.hypot(left, forward)
    if distance <= deadzone or deadzone >= 1:
        return DriveCommand(0.0, 0.0)
    speed = (min(distance, 1.0) - deadzone) / (1 - deadzone)
    return DriveCommand(math.degrees(math.atan2(-left, forward)), speed)


FORMULAS: dict[str, Formula] = {"reference": reference_command, "radial": radial_command}


def _float32(value: float) -> float:
    number: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return number
