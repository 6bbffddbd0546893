"""Most of tf.transformations: quaternions (x, y, z, w), Euler angles and 4x4 matrices.

Results are numpy arrays if numpy is installed, lists otherwise. Angles are in radians. Four letters name the
order of Euler angles: `s` for fixed (static) or `r` for rotating axes, and the axes in order (source:
Shoemake, Euler Angle Conversion, in Graphics Gems IV).
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from functools import cache
from typing import Any

from rostether.robot.transform import conjugated, multiply, slerp
from rostether.robot.transform import quaternion_from_matrix as _from_matrix

# As in tf.transformations: four times the precision of a double.
EPSILON = 4 * 2.0**-52
_LETTERS = "xyz"


def identity_matrix() -> Any:
    """Return the 4x4 identity."""
    return as_array(_identity())


def translation_matrix(direction: Sequence[float]) -> Any:
    """Return the matrix of a translation."""
    matrix = _identity()
    for row in range(3):
        matrix[row][3] = float(direction[row])
    return as_array(matrix)


def translation_from_matrix(matrix: Any) -> Any:
    """Return the translation of a matrix."""
    return as_array([float(matrix[row][3]) for row in range(3)])


def rotation_matrix(angle: float, direction: Sequence[float], point: Sequence[float] | None = None) -> Any:
    """Return the matrix of a rotation about an axis through the origin or a point."""
    matrix = _rows(quaternion_matrix(quaternion_about_axis(angle, direction)))
    if point is not None:
        for row in range(3):
            turned = sum(matrix[row][column] * point[column] for column in range(3))
            matrix[row][3] = point[row] - turned
    return as_array(matrix)


def inverse_matrix(matrix: Any) -> Any:
    """Return the inverse of a matrix; without numpy, the matrix must be a rigid transform."""
    if (numpy := numpy_module()) is not None:
        return numpy.linalg.inv(matrix)
    rows = _rows(matrix)
    result = _identity()
    for row in range(3):
        for column in range(3):
            result[row][column] = rows[column][row]
        result[row][3] = -sum(rows[column][row] * rows[column][3] for column in range(3))
    return as_array(result)


def concatenate_matrices(*matrices: Any) -> Any:
    """Return the product of matrices."""
    product = _identity()
    for matrix in matrices:
        rows = _rows(matrix)
        product = [
            [sum(product[row][k] * rows[k][column] for k in range(4)) for column in range(4)]
            for row in range(4)
        ]
    return as_array(product)


def euler_matrix(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Any:
    """Return the matrix of three Euler angles. Raises ValueError for unknown `axes`."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: Any, axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the Euler angles of a matrix; of several solutions, the one that tf returns.

    Raises ValueError for unknown `axes`.
    """
    is_rotating, (i, j, k), is_first_repeated, is_odd = _convention(axes)
    m = _rows(matrix)
    if is_first_repeated:
        size = math.hypot(m[i][j], m[i][k])
        if size > EPSILON:
            angles = math.atan2(m[i][j], m[i][k]), math.atan2(size, m[i][i]), math.atan2(m[j][i], -m[k][i])
        else:
            angles = math.atan2(-m[j][k], m[j][j]), math.atan2(size, m[i][i]), 0.0
    else:
        size = math.hypot(m[i][i], m[j][i])
        if size > EPSILON:
            angles = math.atan2(m[k][j], m[k][k]), math.atan2(-m[k][i], size), math.atan2(m[j][i], m[i][i])
        else:
            angles = math.atan2(-m[j][k], m[j][j]), math.atan2(-m[k][i], size), 0.0
    first, second, third = (-angle for angle in angles) if is_odd else angles
    return (third, second, first) if is_rotating else (first, second, third)


def euler_from_quaternion(quaternion: Sequence[float], axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the Euler angles of a quaternion; `sxyz` are roll, pitch and yaw.

    Raises ValueError for unknown `axes`.
    """
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Any:
    """Return the quaternion of three Euler angles; `sxyz` are roll, pitch and yaw.

    Raises ValueError for unknown `axes`.
    """
    is_rotating = _convention(axes)[0]
    first, second, third = (
        _axis_rotation(_LETTERS.index(letter), angle)
        for letter, angle in zip(axes[1:], (ai, aj, ak), strict=True)
    )
    if is_rotating:
        return as_array(multiply(multiply(first, second), third))
    return as_array(multiply(multiply(third, second), first))


def quaternion_about_axis(angle: float, axis: Sequence[float]) -> Any:
    """Return the quaternion of a rotation by an angle in radians about an axis."""
    x, y, z = unit_vector(axis)
    sine = math.sin(angle / 2.0)
    return as_array([float(x) * sine, float(y) * sine, float(z) * sine, math.cos(angle / 2.0)])


def quaternion_matrix(quaternion: Sequence[float]) -> Any:
    """Return the 4x4 matrix of a quaternion of any length."""
    x, y, z, w = (float(part) for part in quaternion)
    norm = x * x + y * y + z * z + w * w
    if norm < EPSILON:
        return identity_matrix()
    s = 2.0 / norm
    return as_array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0.0],
            [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w), 0.0],
            [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y), 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def quaternion_from_matrix(matrix: Any) -> Any:
    """Return the quaternion of a rotation matrix."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = _rows(matrix)[:3]
    return as_array(_from_matrix(((a, b, c), (d, e, f), (g, h, i))))


def quaternion_multiply(quaternion1: Sequence[float], quaternion0: Sequence[float]) -> Any:
    """Return the rotation by `quaternion0` first, then by `quaternion1`."""
    return as_array(multiply(_as_quaternion(quaternion1), _as_quaternion(quaternion0)))


def quaternion_conjugate(quaternion: Sequence[float]) -> Any:
    """Return the conjugate."""
    return as_array(conjugated(_as_quaternion(quaternion)))


def quaternion_inverse(quaternion: Sequence[float]) -> Any:
    """Return the inverse."""
    x, y, z, w = _as_quaternion(quaternion)
    norm = x * x + y * y + z * z + w * w
    return as_array([-x / norm, -y / norm, -z / norm, w / norm])


def quaternion_slerp(
    quat0: Sequence[float], quat1: Sequence[float], fraction: float, spin: int = 0, shortestpath: bool = True
) -> Any:
    """Return the rotation at a fraction of the way between two, with `spin` additional half turns."""
    start, end = (_as_quaternion(unit_vector(each)) for each in (quat0, quat1))
    if fraction in (0.0, 1.0):
        return as_array(end if fraction else start)
    if shortestpath and not spin:
        return as_array(slerp(start, end, fraction))
    cosine = sum(one * two for one, two in zip(start, end, strict=True))
    if abs(abs(cosine) - 1.0) < EPSILON:
        return as_array(start)
    if shortestpath and cosine < 0.0:
        cosine, end = -cosine, (-end[0], -end[1], -end[2], -end[3])
    angle = math.acos(cosine) + spin * math.pi
    first, second = (math.sin(part * angle) / math.sin(angle) for part in (1.0 - fraction, fraction))
    return as_array([first * one + second * two for one, two in zip(start, end, strict=True)])


def random_quaternion(rand: Sequence[float] | None = None) -> Any:
    """Return a random rotation, uniformly distributed; `rand` are three numbers from 0 to 1."""
    size, first, second = (random.random() for _ in range(3)) if rand is None else rand  # noqa: S311
    first, second = 2 * math.pi * first, 2 * math.pi * second
    a, b = math.sqrt(1.0 - size), math.sqrt(size)
    return as_array([math.sin(first) * a, math.cos(first) * a, math.sin(second) * b, math.cos(second) * b])


def vector_norm(data: Any, axis: int | None = None, out: Any = None) -> Any:
    """Return the length of a vector, or the lengths along an axis of an array (needs numpy).

    With `out`, stores the result in it and returns None.
    """
    if out is not None:
        out[...] = vector_norm(data, axis)
        return None
    if (numpy := numpy_module()) is not None and numpy.ndim(data) != 1:
        return numpy.atleast_1d(numpy.sqrt(numpy.sum(numpy.square(data), axis=axis)))
    return math.sqrt(sum(float(each) * float(each) for each in data))


def unit_vector(data: Any, axis: int | None = None, out: Any = None) -> Any:
    """Return a vector with length one, or the vectors along an axis of an array (needs numpy).

    With `out`, stores the result in it and returns None.
    """
    if out is not None:
        out[...] = unit_vector(data, axis)
        return None
    if (numpy := numpy_module()) is not None and numpy.ndim(data) != 1:
        lengths = vector_norm(data, axis)
        return numpy.array(data, dtype=float) / (
            lengths if axis is None else numpy.expand_dims(lengths, axis)
        )
    length = vector_norm(data)
    return as_array([float(each) / length for each in data])


def _convention(axes: str) -> tuple[bool, tuple[int, int, int], bool, bool]:
    """Read an axes string of tf.transformations, such as `sxyz`.

    Returns whether the frame rotates (`r`), the indices of the axes, whether the first axis is also the last,
    and whether their order is an odd permutation of x, y, z. Raises ValueError.
    """
    letters = axes[1:]
    if len(axes) != 4 or axes[0] not in "sr" or any(letter not in _LETTERS for letter in letters):
        raise ValueError(f"{axes!r} are not axes; give s or r, and three of x, y, z")
    is_rotating = axes[0] == "r"
    if is_rotating:
        letters = letters[::-1]
    i, j = _LETTERS.index(letters[0]), _LETTERS.index(letters[1])
    if i == j or letters[1] == letters[2]:
        raise ValueError(f"{axes!r} are not axes; two neighboring axes must differ")
    return is_rotating, (i, j, 3 - i - j), letters[0] == letters[2], (j - i) % 3 != 1


def _axis_rotation(axis: int, angle: float) -> tuple[float, float, float, float]:
    parts = [0.0, 0.0, 0.0, math.cos(angle / 2.0)]
    parts[axis] = math.sin(angle / 2.0)
    return parts[0], parts[1], parts[2], parts[3]


def _as_quaternion(values: Sequence[float]) -> tuple[float, float, float, float]:
    x, y, z, w = (float(value) for value in values)
    return x, y, z, w


def _identity() -> list[list[float]]:
    return [[float(row == column) for column in range(4)] for row in range(4)]


def _rows(matrix: Any) -> list[list[float]]:
    return [[float(value) for value in row] for row in matrix]


def as_array(values: Any) -> Any:
    """Return numbers as a numpy array if numpy is installed, as a list otherwise."""
    numpy = numpy_module()
    return list(values) if numpy is None else numpy.array(values)


@cache
def numpy_module() -> Any:
    """Return numpy; None if it is not installed."""
    from importlib import import_module

    try:
        return import_module("numpy")
    except ImportError:
        return None
