"""The functions of tf.transformations for 4x4 matrices that are not rigid.

They need numpy, and raise ImportError if it is not installed.
A matrix acts on column vectors (x, y, z, 1). M is its upper left 3x3 part, t its last column.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rostether.rospy.tf import rotations

# The rounding errors in matrices that users compute.
TOLERANCE = 1e-8
ORTHOGONAL_TOLERANCE = 1e-6


def require_numpy() -> Any:
    """Return numpy. Raises ImportError if it is not installed."""
    numpy = rotations.numpy_module()
    if numpy is None:
        raise ImportError("this function of tf.transformations needs numpy; run: pip install numpy")
    return numpy


def affine(linear: Any, translation: Any) -> Any:
    """Return the matrix of a linear part and a translation."""
    matrix = require_numpy().identity(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = translation
    return matrix


def vector3(values: Any) -> Any:
    """Return the first three numbers."""
    return require_numpy().array(values, dtype=float)[:3]


def unit3(values: Any) -> Any:
    """Return the first three numbers as a vector of length one."""
    vector = vector3(values)
    return vector / require_numpy().linalg.norm(vector)


def linear_and_translation(matrix: Any) -> tuple[Any, Any]:
    """Return the two parts of a matrix."""
    matrix = require_numpy().array(matrix, dtype=float)
    return matrix[:3, :3], matrix[:3, 3]


def homogeneous(values: Any) -> Any:
    """Return a point as (x, y, z, 1)."""
    return require_numpy().append(values, 1.0)


def rank_one(linear: Any, name: str) -> tuple[Any, float, Any]:
    """Return u, s, v with linear = s * outer(u, v). Raises ValueError."""
    left, sizes, right = require_numpy().linalg.svd(linear)
    if sizes[0] < TOLERANCE or sizes[1] > TOLERANCE * max(1.0, sizes[0]):
        raise ValueError(f"the matrix is not a {name}")
    return left[:, 0], float(sizes[0]), right[0]


def is_same_transform(matrix0: Any, matrix1: Any) -> bool:
    """Return whether two matrices perform the same transformation."""
    one, two = (require_numpy().array(each, dtype=float) for each in (matrix0, matrix1))
    return bool(require_numpy().allclose(one / one[3, 3], two / two[3, 3]))


def reflection_matrix(point: Sequence[float], normal: Sequence[float]) -> Any:
    """Return the reflection across the plane through a point; its linear part is 1 - 2 n n'."""
    n = unit3(normal)
    return affine(
        require_numpy().identity(3) - 2.0 * require_numpy().outer(n, n), 2.0 * (vector3(point) @ n) * n
    )


def reflection_from_matrix(matrix: Any) -> tuple[Any, Any]:
    """Return a point of the plane (x, y, z, 1) and its normal. Raises ValueError."""
    linear, translation = linear_and_translation(matrix)
    n, size, other = rank_one(require_numpy().identity(3) - linear, "reflection")
    if abs(size - 2.0) > TOLERANCE or n @ other < 1.0 - TOLERANCE:
        raise ValueError("the matrix is not a reflection")
    return homogeneous((translation @ n) / 2.0 * n), n


def rotation_from_matrix(matrix: Any) -> tuple[float, Any, Any]:
    """Return the angle, the axis and a point of the axis (x, y, z, 1). Raises ValueError."""
    np = require_numpy()
    linear, translation = linear_and_translation(matrix)
    if not np.allclose(linear @ linear.T, np.identity(3)) or np.linalg.det(linear) < 0.0:
        raise ValueError("the matrix is not a rotation")
    # The axis is the direction that does not change.
    axis = np.linalg.svd(linear - np.identity(3))[2][2]
    skew_part = np.array(
        [linear[2, 1] - linear[1, 2], linear[0, 2] - linear[2, 0], linear[1, 0] - linear[0, 1]]
    )
    angle = math.atan2(skew_part @ axis / 2.0, (np.trace(linear) - 1.0) / 2.0)
    point = np.linalg.lstsq(np.identity(3) - linear, translation, rcond=TOLERANCE)[0]
    return angle, axis, homogeneous(point)


def scale_matrix(
    factor: float, origin: Sequence[float] | None = None, direction: Sequence[float] | None = None
) -> Any:
    """Return the scaling about an origin, in all directions or one: M = 1 + (factor - 1) d d'."""
    np = require_numpy()
    change = np.identity(3)
    if direction is not None:
        change = np.outer(unit3(direction), unit3(direction))
    change = (factor - 1.0) * change
    return affine(np.identity(3) + change, 0.0 if origin is None else -change @ vector3(origin))


def scale_from_matrix(matrix: Any) -> tuple[float, Any, Any]:
    """Return the factor, the origin (x, y, z, 1) and the direction, None for all. Raises ValueError."""
    np = require_numpy()
    linear, translation = linear_and_translation(matrix)
    change = linear - np.identity(3)
    direction = None
    size = float(change[0, 0])
    if not np.allclose(change, size * np.identity(3)):
        direction, size, other = rank_one(change, "scaling")
        if abs(direction @ other) < 1.0 - TOLERANCE:
            raise ValueError("the matrix is not a scaling")
        size *= float(np.sign(direction @ other))
    return size + 1.0, homogeneous(-translation / size if abs(size) > TOLERANCE else np.zeros(3)), direction


def shear_matrix(
    angle: float, direction: Sequence[float], point: Sequence[float], normal: Sequence[float]
) -> Any:
    """Return the shear along a direction of a plane: M = 1 + tan(angle) d n'. Raises ValueError."""
    d, n = unit3(direction), unit3(normal)
    if abs(d @ n) > ORTHOGONAL_TOLERANCE:
        raise ValueError("direction and normal are not orthogonal")
    change = math.tan(angle) * require_numpy().outer(d, n)
    return affine(require_numpy().identity(3) + change, -change @ vector3(point))


def shear_from_matrix(matrix: Any) -> tuple[float, Any, Any, Any]:
    """Return the arguments of `shear_matrix` for a matrix. Raises ValueError."""
    linear, translation = linear_and_translation(matrix)
    direction, size, normal = rank_one(linear - require_numpy().identity(3), "shear")
    if abs(direction @ normal) > ORTHOGONAL_TOLERANCE:
        raise ValueError("the matrix is not a shear")
    return math.atan(size), direction, homogeneous(-(translation @ direction) / size * normal), normal


def compose_matrix(
    scale: Sequence[float] | None = None,
    shear: Sequence[float] | None = None,
    angles: Sequence[float] | None = None,
    translate: Sequence[float] | None = None,
    perspective: Sequence[float] | None = None,
) -> Any:
    """Return the product of perspective, translation, rotation (Euler angles), shear and scaling."""
    np = require_numpy()
    linear = np.identity(3)
    if angles is not None:
        first, second, third = angles
        linear = rotations.euler_matrix(first, second, third)[:3, :3]
    if shear is not None:
        xy, xz, yz = shear
        linear = linear @ np.array([[1.0, xy, xz], [0.0, 1.0, yz], [0.0, 0.0, 1.0]])
    if scale is not None:
        linear = linear * np.array(scale, dtype=float)
    matrix = affine(linear, 0.0 if translate is None else vector3(translate))
    if perspective is not None:
        matrix[3] = np.array(perspective, dtype=float)[:4] @ matrix
    return matrix / matrix[3, 3]


def decompose_matrix(matrix: Any) -> tuple[Any, list[float], list[float], Any, Any]:
    """Return scale, shear, angles, translation and perspective: the arguments of `compose_matrix`.

    Raises ValueError for a matrix that has no inverse.
    """
    np = require_numpy()
    matrix = np.array(matrix, dtype=float)
    if abs(matrix[3, 3]) < TOLERANCE:
        raise ValueError("the last element of the matrix is zero")
    matrix = matrix / matrix[3, 3]
    last = matrix[3].copy()
    matrix[3] = 0.0, 0.0, 0.0, 1.0
    linear, translation = linear_and_translation(matrix)
    if abs(np.linalg.det(linear)) < TOLERANCE**2:
        raise ValueError("the matrix has no inverse")
    perspective = last @ np.linalg.inv(matrix) if np.any(np.abs(last[:3]) > TOLERANCE) else matrix[3].copy()
    # A rotation, and a triangle with the scales in its diagonal.
    rotation, triangle = np.linalg.qr(linear)
    signs = np.sign(np.diag(triangle))
    rotation, triangle = rotation * signs, (triangle.T * signs).T
    scale = np.diag(triangle).copy()
    shear = [float(each) for each in (triangle[0, 1] / scale[1], *triangle[:2, 2] / scale[2])]
    if np.linalg.det(rotation) < 0.0:
        rotation, scale = -rotation, -scale
    return scale, shear, list(rotations.euler_from_matrix(affine(rotation, 0.0))), translation, perspective


def orthogonalization_matrix(lengths: Sequence[float], angles: Sequence[float]) -> Any:
    """Return the matrix from the coordinates of a crystal cell (angles in degrees) to orthogonal ones."""
    np = require_numpy()
    a, b, c = lengths
    cos_alpha, cos_beta, cos_gamma = np.cos(np.radians(angles))
    sin_alpha, sin_beta = np.sin(np.radians(angles))[:2]
    reciprocal = (cos_alpha * cos_beta - cos_gamma) / (sin_alpha * sin_beta)
    return affine(
        [
            [a * sin_beta * math.sqrt(1.0 - reciprocal**2), 0.0, 0.0],
            [-a * sin_beta * reciprocal, b * sin_alpha, 0.0],
            [a * cos_beta, b * cos_alpha, c],
        ],
        0.0,
    )


def superimposition_matrix(v0: Any, v1: Any, scaling: bool = False, usesvd: bool = True) -> Any:
    """Return the rigid transform that maps points (3xN) closest to others; `scaling` allows a scale factor.

    `usesvd` has no effect.
    """
    np = require_numpy()
    start, end = (np.array(each, dtype=float)[:3] for each in (v0, v1))
    start_center, end_center = start.mean(axis=1), end.mean(axis=1)
    start, end = start - start_center[:, None], end - end_center[:, None]
    left, _, right = np.linalg.svd(end @ start.T)
    # The sign excludes a reflection.
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    linear = left @ right
    if scaling:
        linear = linear * math.sqrt((end**2).sum() / (start**2).sum())
    return affine(linear, end_center - linear @ start_center)


def random_rotation_matrix(rand: Sequence[float] | None = None) -> Any:
    """Return the matrix of `random_quaternion`."""
    return rotations.quaternion_matrix(rotations.random_quaternion(rand))


def random_vector(size: int) -> Any:
    """Return random numbers from 0 to 1."""
    return require_numpy().random.random(size)
