"""Examples with servos, transforms and attitude."""

from __future__ import annotations

import math
import time

import pytest

from firmware.examples.attitudes import degrees_apart, from_angles, yaw_of
from firmware.examples.stage import running

TF = "tf/tfMessage"


async def test_servo_control(kind: str) -> None:
    async with running("ServoControl", kind) as stage:
        servo = await stage.publisher("/servo", "std_msgs/UInt16")
        assert await stage.board.servo_pulse_us("D9") == pytest.approx(1500, abs=10)
        led = False
        for angle in (0, 45, 137, 180):
            servo.publish(data=angle)
            led = not led
            await stage.board.wait_for_pin("D13", led)
            await stage.wait_for_servo("D9", angle)
            pulse_us = await stage.board.servo_pulse_us("D9")
            assert pulse_us == pytest.approx(544 + angle * (2400 - 544) / 180, abs=10)


async def test_time_tf(kind: str) -> None:
    async with running("TimeTF", kind) as stage:
        inbox = await stage.listen("/tf", TF)
        await inbox.wait_for(
            lambda message: message.transforms[0].header.stamp.secs
        )  # the board has the time
        messages = await inbox.next_messages(5)
        now_s = time.time()
        stamps = []
        for message in messages:
            (frame,) = message.transforms
            assert (frame.header.frame_id, frame.child_frame_id) == ("odom", "base_link")
            assert frame.transform.translation.x == 1.0
            assert frame.transform.rotation.w == 1.0
            stamps.append(frame.header.stamp.to_s())
        assert stamps == sorted(set(stamps))
        # The board's clock follows the host's, and a busy machine simulates the board late.
        assert stamps[-1] == pytest.approx(now_s, abs=1.0)


async def test_odom_drives_in_a_circle(kind: str) -> None:
    radius, turn_rate = 0.2 / 0.36, 0.36
    async with running("Odom", kind) as stage:
        inbox = await stage.listen("/tf", TF)
        await inbox.wait_for(
            lambda message: message.transforms[0].header.stamp.secs
        )  # the board has the time
        frames = [message.transforms[0] for message in await inbox.next_messages(30)]
        for frame in frames:
            assert (frame.header.frame_id, frame.child_frame_id) == ("odom", "base_link")
            yaw = yaw_of(frame.transform.rotation)
            position = frame.transform.translation
            # The center of the circle, (0, radius), is one radius to the robot's left.
            assert position.x - radius * math.sin(yaw) == pytest.approx(0, abs=0.01)
            assert position.y + radius * math.cos(yaw) == pytest.approx(radius, abs=0.01)
        first, last = frames[0], frames[-1]
        turned = yaw_of(last.transform.rotation) - yaw_of(first.transform.rotation)
        passed_s = last.header.stamp.to_s() - first.header.stamp.to_s()
        # On a busy machine, the board's clock is late between two time answers.
        assert turned / passed_s == pytest.approx(turn_rate, rel=0.2)


async def test_imu_shows_the_attitude(kind: str) -> None:
    async with running("IMU", kind, ["attitude 10 10 10"]) as stage:
        imu = await stage.listen("/imu_data", "sensor_msgs/Imu")
        tf = await stage.listen("/tf", TF)
        await imu.wait_for()
        for degrees in ((0, 0, 0), (30, -20, 90), (-170, 40, -135), (0, 88, 10)):
            angles = [math.radians(angle) for angle in degrees]
            expected = from_angles(*angles)
            await stage.board.set_attitude(*angles)
            await imu.wait_for(lambda message: degrees_apart(message.orientation, expected) < 2)  # noqa: B023
            await imu.wait_for()
            for message in await imu.next_messages(5):
                assert degrees_apart(message.orientation, expected) < 2
                assert message.header.frame_id == "imu_link"
                assert message.orientation_covariance[0] > 0
            (frame,) = (await tf.wait_for()).transforms
            assert (frame.header.frame_id, frame.child_frame_id) == ("base_link", "imu_link")
            assert degrees_apart(frame.transform.rotation, expected) < 2
            position = frame.transform.translation
            assert math.hypot(position.x, position.y, position.z) == 1


async def test_imu_follows_a_turn() -> None:
    async with running("IMU") as stage:
        imu = await stage.listen("/imu_data", "sensor_msgs/Imu")
        await imu.wait_for()
        await stage.board.set_attitude(0, 0, math.pi / 2, over_s=2)
        turning = await imu.wait_for(lambda message: message.angular_velocity.z > 0.1)
        # A quarter turn in two seconds.
        assert turning.angular_velocity.z == pytest.approx(math.pi / 4, abs=0.02)
        acceleration = turning.linear_acceleration
        assert (acceleration.x, acceleration.y, acceleration.z) == pytest.approx((0, 0, 9.81), abs=0.1)
        final_attitude = from_angles(0, 0, math.pi / 2)
        at_rest = await imu.wait_for(lambda message: message.angular_velocity.z < 0.1)
        # The measurements follow the turn, without a jump.
        assert degrees_apart(at_rest.orientation, final_attitude) < 8
        await imu.wait_for(lambda message: degrees_apart(message.orientation, final_attitude) < 2)
