from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.robot.transform import (
    IDENTITY_ROTATION,
    Transform,
    interpolate,
    matrix_from_axis_angle,
    matrix_from_quaternion,
    matrix_product,
    matrix_times_vector,
    quaternion_from_matrix,
    quaternion_from_rpy,
    rotate,
    rpy_from_quaternion,
    slerp,
)

angles = st.floats(-3.1, 3.1)
lengths = st.floats(-100, 100)
vectors = st.tuples(lengths, lengths, lengths)
rotations = st.builds(quaternion_from_rpy, angles, angles, angles)
transforms = st.builds(Transform, vectors, rotations)


@given(transforms, vectors)
def test_an_inverse_restores_points(transform: Transform, point: tuple[float, float, float]) -> None:
    assert transform.inverse().apply(transform.apply(point)) == pytest.approx(point, abs=1e-9)


@given(transforms, transforms, vectors)
def test_a_product_applies_the_right_factor_first(
    left: Transform, right: Transform, point: tuple[float, float, float]
) -> None:
    assert (left @ right).apply(point) == pytest.approx(left.apply(right.apply(point)), abs=1e-9)


@given(rotations, vectors)
def test_matrix_and_quaternion_rotate_equally(
    rotation: tuple[float, float, float, float], vector: tuple[float, float, float]
) -> None:
    matrix = matrix_from_quaternion(rotation)
    assert matrix_times_vector(matrix, vector) == pytest.approx(rotate(rotation, vector), abs=1e-9)
    back = quaternion_from_matrix(matrix)
    assert abs(sum(a * b for a, b in zip(back, rotation, strict=True))) == pytest.approx(1.0)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_roll_pitch_yaw_survive_a_round_trip(roll: float, pitch: float, yaw: float) -> None:
    assert rpy_from_quaternion(quaternion_from_rpy(roll, pitch, yaw)) == pytest.approx(
        (roll, pitch, yaw), abs=1e-7
    )


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_a_pitch_of_90_degrees_keeps_the_rotation(pitch: float) -> None:
    rotation = quaternion_from_rpy(0.3, pitch, 0.7)
    back = quaternion_from_rpy(*rpy_from_quaternion(rotation))
    assert abs(sum(a * b for a, b in zip(back, rotation, strict=True))) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_half_a_turn_about_each_axis(axis: tuple[float, float, float]) -> None:
    rotation = quaternion_from_matrix(matrix_from_axis_angle(axis, math.pi))
    assert rotation == pytest.approx((*axis, 0.0), abs=1e-9)


def test_rotations_about_an_axis_add_up() -> None:
    axis = (0.6, 0.0, 0.8)
    both = matrix_product(matrix_from_axis_angle(axis, 0.4), matrix_from_axis_angle(axis, 0.5))
    for row, expected in zip(both, matrix_from_axis_angle(axis, 0.9), strict=True):
        assert row == pytest.approx(expected)


def test_halfway_is_half_the_translation_and_half_the_rotation() -> None:
    start = Transform((0.0, 0.0, 0.0), IDENTITY_ROTATION)
    end = Transform((2.0, 4.0, 6.0), quaternion_from_rpy(0, 0, 1.0))
    middle = interpolate(start, end, 0.5)
    assert middle.translation == (1.0, 2.0, 3.0)
    assert middle.rotation == pytest.approx(quaternion_from_rpy(0, 0, 0.5))


def test_the_same_rotation_twice_interpolates_to_itself() -> None:
    assert slerp(IDENTITY_ROTATION, IDENTITY_ROTATION, 0.3) == IDENTITY_ROTATION


def test_a_long_quaternion_is_normalized() -> None:
    assert Transform(rotation=(0.0, 0.0, 0.0, 2.0)).normalized().rotation == IDENTITY_ROTATION
