"""Rigid transforms: rotations as unit quaternions (x, y, z, w), translations in meters.

The formulas follow tf2 and KDL, including the signs of quaternions, so that results can be compared number by
number. They use plain floats: a robot has tens of joints, and importing numpy would cost more time than it
saves.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

from msgspec import Struct

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]

IDENTITY_ROTATION: Quaternion = (0.0, 0.0, 0.0, 1.0)

# A smaller trace is zero with a rounding error; KDL uses the same limit.
_TRACE_EPSILON = 1e-12

# The tolerance of tf2 for the square of a quaternion's length.
_NORM_TOLERANCE = 10e-3


class Transform(Struct, frozen=True):
    """Converts points from the child's to the parent's frame: first the rotation, then the translation."""

    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = IDENTITY_ROTATION

    def __matmul__(self, other: Transform) -> Transform:
        """Return the transform that applies `other` first, then this one."""
        return Transform(self.apply(other.translation), multiply(self.rotation, other.rotation))

    def apply(self, point: Vector) -> Vector:
        """Return a point of the child's frame in the parent's frame."""
        x, y, z = rotate(self.rotation, point)
        tx, ty, tz = self.translation
        return x + tx, y + ty, z + tz

    def normalized(self) -> Transform:
        """Return the transform with a rotation of length 1."""
        x, y, z, w = self.rotation
        length = math.sqrt(x * x + y * y + z * z + w * w)
        return Transform(self.translation, (x / length, y / length, z / length, w / length))

    def inverse(self) -> Transform:
        """Return the transform from the parent's frame to the child's frame."""
        conjugate = conjugated(self.rotation)
        x, y, z = self.translation
        return Transform(rotate(conjugate, (-x, -y, -z)), conjugate)


IDENTITY = Transform()


class StampedTransform(Struct, frozen=True):
    """The pose of the frame `child` in the frame `parent` at a time, in nanoseconds since the epoch."""

    parent: str
    child: str
    stamp_ns: int
    transform: Transform


def transform_of(message: Any) -> Transform:
    """Return the transform in a geometry_msgs/TransformStamped."""
    translation, rotation = message.transform.translation, message.transform.rotation
    return Transform(
        (translation.x, translation.y, translation.z), (rotation.x, rotation.y, rotation.z, rotation.w)
    )


def has_unit_length(rotation: Quaternion) -> bool:
    """Return whether tf2 accepts a quaternion as a rotation."""
    return abs(sum(each * each for each in rotation) - 1.0) < _NORM_TOLERANCE


def conjugated(rotation: Quaternion) -> Quaternion:
    """Return the inverse rotation of a unit quaternion."""
    x, y, z, w = rotation
    return -x, -y, -z, w


def multiply(left: Quaternion, right: Quaternion) -> Quaternion:
    """Return the rotation by `right`, followed by `left`."""
    ax, ay, az, aw = left
    bx, by, bz, bw = right
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    """Return a vector rotated by a unit quaternion."""
    turned = multiply(multiply(rotation, (*vector, 0.0)), conjugated(rotation))
    return turned[0], turned[1], turned[2]


def slerp(start: Quaternion, end: Quaternion, ratio: float) -> Quaternion:
    """Interpolate two rotations along the shorter path (source: tf2)."""
    dot = sum(a * b for a, b in zip(start, end, strict=True))
    scale = math.sqrt(sum(a * a for a in start) * sum(b * b for b in end))
    angle = math.acos(min(abs(dot) / scale, 1.0)) if scale else 0.0
    if angle == 0.0:
        return start
    divisor = math.sin(angle)
    start_part = math.sin((1.0 - ratio) * angle)
    end_part = math.sin(ratio * angle) * (-1.0 if dot < 0 else 1.0)
    x, y, z, w = ((a * start_part + b * end_part) / divisor for a, b in zip(start, end, strict=True))
    return x, y, z, w


def interpolate(start: Transform, end: Transform, ratio: float) -> Transform:
    """Return the interpolated transform; ratio 0 is the start, 1 the end."""
    x, y, z = ((1.0 - ratio) * a + ratio * b for a, b in zip(start.translation, end.translation, strict=True))
    return Transform((x, y, z), slerp(start.rotation, end.rotation, ratio))


def quaternion_from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation by roll, pitch and yaw in radians about the parent's fixed axes x, y, z."""
    sr, cr = math.sin(roll / 2), math.cos(roll / 2)
    sp, cp = math.sin(pitch / 2), math.cos(pitch / 2)
    sy, cy = math.sin(yaw / 2), math.cos(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def rpy_from_quaternion(rotation: Quaternion) -> Vector:
    """Return roll, pitch and yaw in radians; if pitch is ±90 degrees, yaw is zero."""
    (m00, m01, m02), (m10, _, _), (m20, m21, m22) = matrix_from_quaternion(rotation)
    if abs(m20) >= 1.0 - 1e-15:
        pitch = math.copysign(math.pi / 2, -m20)
        return (math.atan2(m01, m02) if m20 < 0 else math.atan2(-m01, -m02)), pitch, 0.0
    return math.atan2(m21, m22), math.asin(-m20), math.atan2(m10, m00)


def matrix_from_quaternion(rotation: Quaternion) -> Matrix:
    """Return the rotation matrix of a unit quaternion as rows."""
    x, y, z, w = rotation
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    return (
        (ww + xx - yy - zz, 2 * x * y - 2 * w * z, 2 * x * z + 2 * w * y),
        (2 * x * y + 2 * w * z, ww - xx + yy - zz, 2 * y * z - 2 * w * x),
        (2 * x * z - 2 * w * y, 2 * y * z + 2 * w * x, ww - xx - yy + zz),
    )


def quaternion_from_matrix(matrix: Matrix) -> Quaternion:
    """Return the unit quaternion of a rotation matrix, with the sign that KDL gives it."""
    (m00, m01, m02), (m10, m11, m12), (m20, m21, m22) = matrix
    trace = m00 + m11 + m22
    if trace > _TRACE_EPSILON:
        scale = 0.5 / math.sqrt(trace + 1.0)
        return (m21 - m12) * scale, (m02 - m20) * scale, (m10 - m01) * scale, 0.25 / scale
    if m00 > m11 and m00 > m22:
        scale = 2.0 * math.sqrt(1.0 + m00 - m11 - m22)
        return 0.25 * scale, (m01 + m10) / scale, (m02 + m20) / scale, (m21 - m12) / scale
    if m11 > m22:
        scale = 2.0 * math.sqrt(1.0 + m11 - m00 - m22)
        return (m01 + m10) / scale, 0.25 * scale, (m12 + m21) / scale, (m02 - m20) / scale
    scale = 2.0 * math.sqrt(1.0 + m22 - m00 - m11)
    return (m02 + m20) / scale, (m12 + m21) / scale, 0.25 * scale, (m10 - m01) / scale


def matrix_from_axis_angle(axis: Vector, angle_rad: float) -> Matrix:
    """Return the rotation about a unit axis (source: Rodrigues' formula)."""
    x, y, z = axis
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    rest = 1.0 - cosine
    return (
        (cosine + rest * x * x, -z * sine + rest * x * y, y * sine + rest * x * z),
        (z * sine + rest * x * y, cosine + rest * y * y, -x * sine + rest * y * z),
        (-y * sine + rest * x * z, x * sine + rest * y * z, cosine + rest * z * z),
    )


def matrix_times_vector(matrix: Matrix, vector: Vector) -> Vector:
    """Return the product of a matrix and a column."""
    # Written out, because sum() rounds differently in newer Python versions.
    x, y, z = vector
    a, b, c = (row[0] * x + row[1] * y + row[2] * z for row in matrix)
    return a, b, c


def matrix_product(left: Matrix, right: Matrix) -> Matrix:
    """Return the product of two matrices."""
    (a, d, g), (b, e, h), (c, f, i) = (
        matrix_times_vector(left, column) for column in zip(*right, strict=True)
    )
    return (a, b, c), (d, e, f), (g, h, i)
