"""Angles between attitudes."""

from __future__ import annotations

import math
from typing import Any, Protocol


class Quaternion(Protocol):
    """A quaternion, as in messages."""

    x: Any
    y: Any
    z: Any
    w: Any


def from_angles(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return (x, y, z, w) after turns about the fixed axes x, y and z, in radians (REP 103)."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def degrees_apart(measured: Quaternion, expected: tuple[float, float, float, float]) -> float:
    """Return the angle of the rotation between two attitudes."""
    found = (measured.x, measured.y, measured.z, measured.w)
    assert math.isclose(math.hypot(*found), 1, abs_tol=1e-3)
    along = abs(sum(a * b for a, b in zip(found, expected, strict=True)))
    return math.degrees(2 * math.acos(min(along, 1.0)))


def yaw_of(rotation: Quaternion) -> float:
    """Return the rotation about z in radians, for an attitude that is rotated only about z."""
    return 2 * math.atan2(rotation.z, rotation.w)
