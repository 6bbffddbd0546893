from __future__ import annotations

import math
from itertools import pairwise
from random import Random

import pytest

from rostether.simulation.motion import GRAVITY, CircleDrive, Quaternion, Vector
from rostether.simulation.ultrasound import MAX_RANGE, MIN_RANGE, Obstacle, Ultrasound

STEP_S = 1e-4
TIMES_S = [0.0, 0.3, 1.7, 5.0, 12.34, 19.99]


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    x, y, z, w = rotation
    tx, ty, tz = (
        2 * (y * vector.z - z * vector.y),
        2 * (z * vector.x - x * vector.z),
        2 * (x * vector.y - y * vector.x),
    )
    return Vector(
        vector.x + w * tx + y * tz - z * ty,
        vector.y + w * ty + z * tx - x * tz,
        vector.z + w * tz + x * ty - y * tx,
    )


def conjugate(rotation: Quaternion) -> Quaternion:
    return Quaternion(-rotation.x, -rotation.y, -rotation.z, rotation.w)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    return Quaternion(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )


@pytest.mark.parametrize("time_s", TIMES_S)
def test_orientation_is_a_rotation(time_s: float) -> None:
    assert math.hypot(*CircleDrive().pose(time_s).orientation) == pytest.approx(1.0)


@pytest.mark.parametrize("time_s", TIMES_S)
def test_turn_rate_is_the_change_of_the_orientation(time_s: float) -> None:
    drive = CircleDrive()
    before, after = (drive.pose(time_s + shift).orientation for shift in (-STEP_S, STEP_S))
    turned = product(conjugate(before), after)
    rate = [2 * part / (2 * STEP_S) for part in turned[:3]]
    assert rate == pytest.approx(list(drive.imu_values(time_s).turn_rate), abs=1e-5)


@pytest.mark.parametrize("time_s", TIMES_S)
def test_acceleration_is_that_of_the_path_and_gravity(time_s: float) -> None:
    drive = CircleDrive()
    before, here, after = (drive.pose(time_s + shift).position for shift in (-STEP_S, 0.0, STEP_S))
    world = Vector(*((a - 2 * h + b) / STEP_S**2 for a, h, b in zip(after, here, before, strict=True)))
    felt = rotate(conjugate(drive.pose(time_s).orientation), world._replace(z=world.z + GRAVITY))
    assert list(felt) == pytest.approx(list(drive.imu_values(time_s).acceleration), abs=1e-4)


def test_drive_a_circle_forward() -> None:
    drive = CircleDrive(radius=2.0, lap_s=8.0, sway=0.0)
    assert drive.pose(0.0).position == (0.0, 0.0, 0.0)
    assert list(drive.pose(2.0).position) == pytest.approx([2.0, 2.0, 0.0])
    assert list(drive.pose(8.0).position) == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    heading = rotate(drive.pose(2.0).orientation, Vector(1.0, 0.0, 0.0))
    assert list(heading) == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)


def test_the_obstacle_moves_at_walking_speed_within_range() -> None:
    obstacle = Obstacle()
    distances = [obstacle.distance(number / 20) for number in range(2000)]
    assert all(0.2 < distance < 2.8 for distance in distances)
    assert max(abs(b - a) * 20 for a, b in pairwise(distances)) < 1.0
    assert max(distances) - min(distances) > 2.0


def test_readings_scatter_by_millimeters_and_sometimes_lose_an_echo() -> None:
    obstacle = Obstacle()
    sensor = Ultrasound(Random(1), obstacle)
    times_s = [number / 20 for number in range(4000)]
    readings = [sensor.measure(time_s) for time_s in times_s]
    assert all(MIN_RANGE <= reading <= MAX_RANGE for reading in readings)
    lost = readings.count(MAX_RANGE)
    assert 1 < lost < 30
    errors = [
        reading - obstacle.distance(time_s)
        for reading, time_s in zip(readings, times_s, strict=True)
        if reading != MAX_RANGE
    ]
    assert max(map(abs, errors)) < 0.02
    assert 0.001 < (sum(error**2 for error in errors) / len(errors)) ** 0.5 < 0.006


def test_the_same_seed_gives_the_same_noise() -> None:
    readings = [Ultrasound(Random(5), Obstacle()).measure(1.0) for _ in range(3)]
    assert readings == readings[:1] * 3


def test_a_moved_obstacle_stays_within_the_sensors_range() -> None:
    obstacle = Obstacle()
    before = obstacle.distance(3.0)
    obstacle.move(0.1, 3.0)
    assert obstacle.distance(3.0) == obstacle.distance(60.0) == pytest.approx(before + 0.1)
    obstacle.move(9.0, 4.0)
    assert obstacle.distance(5.0) == MAX_RANGE
    obstacle.move(-9.0, 4.0)
    assert obstacle.distance(5.0) == MIN_RANGE


def test_without_an_obstacle_the_sensor_reports_its_maximum() -> None:
    obstacle = Obstacle()
    obstacle.place(math.inf)
    assert Ultrasound(Random(5), obstacle).measure(1.0) == MAX_RANGE
    obstacle.move(-0.1, 1.0)
    assert obstacle.distance(1.0) == MAX_RANGE
