"""Arcball of tf.transformations: rotates an object with the mouse (source: Shoemake, ARCBALL, 1992)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rostether.rospy.tf import rotations

_Vector = Sequence[float]


def arcball_map_to_sphere(point: _Vector, center: _Vector, radius: float) -> Any:
    """Return the point of the unit sphere at a point of the window, whose y axis points down."""
    x, y = (point[0] - center[0]) / radius, (center[1] - point[1]) / radius
    length = math.hypot(x, y)
    if length > 1.0:
        return rotations.as_array([x / length, y / length, 0.0])
    return rotations.as_array([x, y, math.sqrt(1.0 - length * length)])


def arcball_constrain_to_axis(point: _Vector, axis: _Vector) -> Any:
    """Return the nearest point to a point of the sphere on the great circle perpendicular to an axis."""
    along = _dot(point, axis)
    across = [value - along * part for value, part in zip(point, axis, strict=True)]
    if rotations.vector_norm(across) > rotations.EPSILON:
        # Of two opposite points, this is the one on the visible half.
        return rotations.unit_vector([-value for value in across] if across[2] < 0.0 else across)
    if axis[2] == 1.0:
        return rotations.as_array([1.0, 0.0, 0.0])
    return rotations.unit_vector([-axis[1], axis[0], 0.0])


def arcball_nearest_axis(point: _Vector, axes: Sequence[_Vector]) -> _Vector:
    """Return the axis whose great circle is nearest to a point."""
    return max(axes, key=lambda axis: _dot(arcball_constrain_to_axis(point, axis), point))


class Arcball:
    """The rotation of an object; `initial` is a quaternion or a matrix."""

    def __init__(self, initial: Any = None) -> None:
        self._center: _Vector = (0.0, 0.0)
        self._radius = 1.0
        self._axes: list[Any] = []
        self._axis: Any = None
        self._is_constrained = False
        self._start: Any = [0.0, 0.0, 1.0]
        now: Any = (0.0, 0.0, 0.0, 1.0)
        if initial is not None:
            is_matrix = len(initial) == 4 and hasattr(initial[0], "__len__")
            now = rotations.quaternion_from_matrix(initial) if is_matrix else rotations.unit_vector(initial)
        self._down = self._before = self._now = now

    def place(self, center: _Vector, radius: float) -> None:
        """Set the sphere's position in the window."""
        self._center, self._radius = center, float(radius)

    def setaxes(self, *axes: _Vector) -> None:
        """Set the axes of constrained rotations."""
        self._axes = [rotations.unit_vector(axis) for axis in axes]

    def setconstrain(self, constrain: bool) -> None:
        """Set whether the object rotates only about the nearest axis."""
        self._is_constrained = bool(constrain)

    def getconstrain(self) -> bool:
        """Return whether rotations are constrained."""
        return self._is_constrained

    def down(self, point: _Vector) -> None:
        """Handle the start of a drag."""
        self._start = arcball_map_to_sphere(point, self._center, self._radius)
        self._down = self._before = self._now
        self._axis = None
        if self._is_constrained and self._axes:
            self._axis = arcball_nearest_axis(self._start, self._axes)
            self._start = arcball_constrain_to_axis(self._start, self._axis)

    def drag(self, point: _Vector) -> None:
        """Handle a move of the mouse."""
        end = arcball_map_to_sphere(point, self._center, self._radius)
        if self._axis is not None:
            end = arcball_constrain_to_axis(end, self._axis)
        (a, b, c), (d, e, f) = self._start, end
        axis = [b * f - c * e, c * d - a * f, a * e - b * d]
        self._before = self._now
        self._now = self._down
        if _dot(axis, axis) >= rotations.EPSILON:
            self._now = rotations.quaternion_multiply([*axis, _dot(self._start, end)], self._down)

    def next(self, acceleration: float = 0.0) -> None:
        """Continue the rotation of the last drag."""
        ahead = rotations.quaternion_slerp(self._before, self._now, 2.0 + acceleration, shortestpath=False)
        self._before, self._now = self._now, ahead

    def matrix(self) -> Any:
        """Return the rotation as a matrix."""
        return rotations.quaternion_matrix(self._now)


def _dot(one: _Vector, two: _Vector) -> float:
    return sum(float(a) * float(b) for a, b in zip(one, two, strict=True))
