"""tf.transformations, as far as nodes use it: quaternions (x, y, z, w), Euler angles and 4x4 matrices.

Results are numpy arrays where numpy is installed, lists otherwise. Euler angles go by four letters: `s` for
fixed or `r` for turning axes, and the axes in order (source: Shoemake, Euler Angle Conversion, in Graphics
Gems IV).
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from functools import cache
from typing import Any

from rostether.robot.transform import multiply, slerp
from rostether.robot.transform import quaternion_from_matrix as _from_matrix

_EPSILON = 4 * 2.0**-52
_LETTERS = "xyz"


def identity_matrix() -> Any:
    """Return the 4x4 identity."""
    return _array([[float(row == column) for column in range(4)] for row in range(4)])


def translation_matrix(direction: Sequence[float]) -> Any:
    """Return the matrix of a translation."""
    matrix = _identity()
    for row in range(3):
        matrix[row][3] = float(direction[row])
    return _array(matrix)


def translation_from_matrix(matrix: Any) -> Any:
    """Return the translation of a matrix."""
    return _array([float(matrix[row][3]) for row in range(3)])


def rotation_matrix(angle: float, direction: Sequence[float], point: Sequence[float] | None = None) -> Any:
    """Return the matrix of a rotation about an axis through the origin or a point."""
    matrix = _rows(quaternion_matrix(quaternion_about_axis(angle, direction)))
    if point is not None:
        for row in range(3):
            turned = sum(matrix[row][column] * point[column] for column in range(3))
            matrix[row][3] = point[row] - turned
    return _array(matrix)


def inverse_matrix(matrix: Any) -> Any:
    """Return the inverse of a rigid transform's matrix."""
    rows = _rows(matrix)
    result = _identity()
    for row in range(3):
        for column in range(3):
            result[row][column] = rows[column][row]
        result[row][3] = -sum(rows[column][row] * rows[column][3] for column in range(3))
    return _array(result)


def concatenate_matrices(*matrices: Any) -> Any:
    """Return the product of matrices."""
    product = _identity()
    for matrix in matrices:
        rows = _rows(matrix)
        product = [
            [sum(product[row][k] * rows[k][column] for k in range(4)) for column in range(4)]
            for row in range(4)
        ]
    return _array(product)


def euler_matrix(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Any:
    """Return the matrix of three Euler angles."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: Any, axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the Euler angles of a matrix; of several solutions, the one that tf returns."""
    turning, (i, j, k), repeats, is_odd = _convention(axes)
    m = _rows(matrix)
    if repeats:
        size = math.hypot(m[i][j], m[i][k])
        if size > _EPSILON:
            angles = math.atan2(m[i][j], m[i][k]), math.atan2(size, m[i][i]), math.atan2(m[j][i], -m[k][i])
        else:
            angles = math.atan2(-m[j][k], m[j][j]), math.atan2(size, m[i][i]), 0.0
    else:
        size = math.hypot(m[i][i], m[j][i])
        if size > _EPSILON:
            angles = math.atan2(m[k][j], m[k][k]), math.atan2(-m[k][i], size), math.atan2(m[j][i], m[i][i])
        else:
            angles = math.atan2(-m[j][k], m[j][j]), math.atan2(-m[k][i], size), 0.0
    first, second, third = (-angle for angle in angles) if is_odd else angles
    return (third, second, first) if turning else (first, second, third)


def euler_from_quaternion(quaternion: Sequence[float], axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the Euler angles of a quaternion; `sxyz` are roll, pitch and yaw."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Any:
    """Return the quaternion of three Euler angles; `sxyz` are roll, pitch and yaw."""
    turning, letters = axes[0] == "r", axes[1:]
    _convention(axes)
    first, second, third = (
        _about(_LETTERS.index(letter), angle) for letter, angle in zip(letters, (ai, aj, ak), strict=True)
    )
    if turning:
        return _array(multiply(multiply(first, second), third))
    return _array(multiply(multiply(third, second), first))


def quaternion_about_axis(angle: float, axis: Sequence[float]) -> Any:
    """Return the quaternion of a rotation about an axis."""
    x, y, z = unit_vector(axis)
    sine = math.sin(angle / 2.0)
    return _array([float(x) * sine, float(y) * sine, float(z) * sine, math.cos(angle / 2.0)])


def quaternion_matrix(quaternion: Sequence[float]) -> Any:
    """Return the 4x4 matrix of a quaternion of any length."""
    x, y, z, w = (float(part) for part in quaternion)
    norm = x * x + y * y + z * z + w * w
    if norm < _EPSILON:
        return identity_matrix()
    s = 2.0 / norm
    return _array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0.0],
            [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w), 0.0],
            [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y), 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def quaternion_from_matrix(matrix: Any) -> Any:
    """Return the quaternion of a matrix."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = _rows(matrix)[:3]
    return _array(_from_matrix(((a, b, c), (d, e, f), (g, h, i))))


def quaternion_multiply(quaternion1: Sequence[float], quaternion0: Sequence[float]) -> Any:
    """Return the rotation by `quaternion0` first, then by `quaternion1`."""
    return _array(multiply(_four(quaternion1), _four(quaternion0)))


def quaternion_conjugate(quaternion: Sequence[float]) -> Any:
    """Return the conjugate."""
    x, y, z, w = _four(quaternion)
    return _array([-x, -y, -z, w])


def quaternion_inverse(quaternion: Sequence[float]) -> Any:
    """Return the inverse."""
    x, y, z, w = _four(quaternion)
    norm = x * x + y * y + z * z + w * w
    return _array([-x / norm, -y / norm, -z / norm, w / norm])


def quaternion_slerp(quat0: Sequence[float], quat1: Sequence[float], fraction: float) -> Any:
    """Return the rotation at a fraction of the shorter way from one to another."""
    start, end = (_four(unit_vector(each)) for each in (quat0, quat1))
    if fraction in (0.0, 1.0):
        return _array(end if fraction else start)
    return _array(slerp(start, end, fraction))


def random_quaternion() -> Any:
    """Return a random rotation, uniformly distributed."""
    size, first, second = random.random(), 2 * math.pi * random.random(), 2 * math.pi * random.random()  # noqa: S311
    a, b = math.sqrt(1.0 - size), math.sqrt(size)
    return _array([math.sin(first) * a, math.cos(first) * a, math.sin(second) * b, math.cos(second) * b])


def vector_norm(data: Sequence[float]) -> float:
    """Return a vector's length."""
    return math.sqrt(sum(float(each) * float(each) for each in data))


def unit_vector(data: Sequence[float]) -> Any:
    """Return a vector of length one."""
    length = vector_norm(data)
    return _array([float(each) / length for each in data])


def _convention(axes: str) -> tuple[bool, tuple[int, int, int], bool, bool]:
    """Return whether the axes turn, their numbers, whether the first repeats, and whether they go back."""
    letters = axes[1:]
    if len(axes) != 4 or axes[0] not in "sr" or any(letter not in _LETTERS for letter in letters):
        raise ValueError(f"{axes!r} are not axes; give s or r, and three of x, y, z")
    turning = axes[0] == "r"
    if turning:
        letters = letters[::-1]
    i, j = _LETTERS.index(letters[0]), _LETTERS.index(letters[1])
    if i == j or letters[1] == letters[2]:
        raise ValueError(f"{axes!r} are not axes; two neighboring axes must differ")
    return turning, (i, j, 3 - i - j), letters[0] == letters[2], (j - i) % 3 != 1


def _about(axis: int, angle: float) -> tuple[float, float, float, float]:
    parts = [0.0, 0.0, 0.0, math.cos(angle / 2.0)]
    parts[axis] = math.sin(angle / 2.0)
    return parts[0], parts[1], parts[2], parts[3]


def _four(values: Sequence[float]) -> tuple[float, float, float, float]:
    x, y, z, w = (float(value) for value in values)
    return x, y, z, w


def _identity() -> list[list[float]]:
    return [[float(row == column) for column in range(4)] for row in range(4)]


def _rows(matrix: Any) -> list[list[float]]:
    return [[float(value) for value in row] for row in matrix]


def _array(values: Any) -> Any:
    make = _numpy_array()
    return list(values) if make is None else make(values)


@cache
def _numpy_array() -> Any:
    from importlib import import_module

    try:
        return import_module("numpy").array
    except ImportError:
        return None
