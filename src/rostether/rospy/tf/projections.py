"""The projections of tf.transformations. They need numpy, and raise ImportError if it is not installed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rostether.rospy.tf.matrices import (
    ORTHOGONAL_TOLERANCE,
    TOLERANCE,
    affine,
    homogeneous,
    linear_and_translation,
    rank_one,
    require_numpy,
    unit3,
    vector3,
)


def projection_matrix(
    point: Sequence[float],
    normal: Sequence[float],
    direction: Sequence[float] | None = None,
    perspective: Sequence[float] | None = None,
    pseudo: bool = False,
) -> Any:
    """Return the projection onto a plane: orthogonal, along a direction, or towards a point of view.

    With `pseudo`, a projection towards a point keeps the order of depths.
    """
    np = require_numpy()
    n, p = unit3(normal), vector3(point)
    if perspective is None:
        along = n if direction is None else vector3(direction)
        along = along / (along @ n)
        return affine(np.identity(3) - np.outer(along, n), (p @ n) * along)
    eye = vector3(perspective)
    depth = n if pseudo else np.zeros(3)
    matrix = affine(
        ((eye - p) @ n) * np.identity(3) - np.outer(eye, n) - np.outer(depth, n), (p @ n) * (eye + depth)
    )
    matrix[3] = (*-n, eye @ n)
    return matrix


def projection_from_matrix(matrix: Any, pseudo: bool = False) -> tuple[Any, Any, Any, Any, bool]:
    """Return the arguments of `projection_matrix` for a matrix. Raises ValueError."""
    np = require_numpy()
    matrix = np.array(matrix, dtype=float)
    linear, translation = linear_and_translation(matrix)
    last = matrix[3, :3]
    if np.allclose(last, 0.0):
        linear, translation = linear / matrix[3, 3], translation / matrix[3, 3]
        removed = np.identity(3) - linear
        direction, _, normal = rank_one(removed, "projection")
        if abs(removed @ direction @ direction - 1.0) > ORTHOGONAL_TOLERANCE:
            raise ValueError("the matrix is not a projection")
        point = (translation @ direction) * (normal @ direction) * normal
        return homogeneous(point), normal, direction, None, False
    size = np.linalg.norm(last)
    normal, linear, translation, w = -last / size, linear / size, translation / size, matrix[3, 3] / size
    # In `projection_matrix`, with n = normal and e = eye, or eye + n with `pseudo`: linear = scale I - e n',
    # translation = (point n) e, w = eye n, and scale = w - point n.
    outer = np.outer(normal, normal)
    across = np.identity(3) - outer
    scale = float(np.trace(across @ linear @ across)) / 2.0
    e = scale * normal - linear @ normal
    eye = e - normal if pseudo else e
    if abs(eye @ normal - w) > ORTHOGONAL_TOLERANCE * max(1.0, abs(w)):
        raise ValueError("the matrix is not a projection")
    return homogeneous((w - scale) * normal), normal, None, eye, pseudo


def clip_matrix(
    left: float, right: float, bottom: float, top: float, near: float, far: float, perspective: bool = False
) -> Any:
    """Return the matrix from camera space to normalized device coordinates. Raises ValueError."""
    if left >= right or bottom >= top or near >= far:
        raise ValueError("left, bottom and near must be less than right, top and far")
    width, height, depth = right - left, top - bottom, far - near
    if not perspective:
        return require_numpy().array(
            [
                [2.0 / width, 0.0, 0.0, -(right + left) / width],
                [0.0, 2.0 / height, 0.0, -(top + bottom) / height],
                [0.0, 0.0, 2.0 / depth, -(far + near) / depth],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    if near <= TOLERANCE:
        raise ValueError("near must be positive for a perspective")
    return require_numpy().array(
        [
            [-2.0 * near / width, 0.0, (right + left) / width, 0.0],
            [0.0, -2.0 * near / height, (top + bottom) / height, 0.0],
            [0.0, 0.0, -(far + near) / depth, 2.0 * near * far / depth],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )
