"""The complete board of a robot: all its topics on one line, even on an Uno."""

from __future__ import annotations

import asyncio
import contextlib
import math
import struct
from collections.abc import AsyncIterator

import pytest

from firmware.examples.attitudes import yaw_of
from firmware.examples.stage import TIMEOUT_S, Stage, build_example, running
from firmware.robustness.scripted_host import ScriptedHost
from rostether.graph.typed_handles import TypedPublisher
from rostether.rosserial import topic_id
from rostether.rosserial.packets import TopicInfo

ODOM = "nav_msgs/Odometry"
WHEEL_RADIUS, WHEEL_SEPARATION = 0.033, 0.16
TRIES = 10
TIME = struct.pack("<II", 1_700_000_000, 0)


@contextlib.asynccontextmanager
async def driving(cmd_vel: TypedPublisher[...], speed: float, turn_rate: float) -> AsyncIterator[None]:
    """Command a speed ten times a second."""

    async def command() -> None:
        while True:
            cmd_vel.publish(linear={"x": speed}, angular={"z": turn_rate})
            await asyncio.sleep(0.1)

    commanding = asyncio.create_task(command())
    try:
        yield
    finally:
        commanding.cancel()


async def wait_for_duty(stage: Stage, pin: str, expected: float) -> None:
    """Wait until a motor's PWM has this duty."""

    def has_duty() -> bool:
        reported = [each for each in stage.board.recent if each.name == "pwm" and each["pin"] == pin]
        return bool(reported) and abs(reported[-1]["duty"] - expected) < 0.02

    async with asyncio.timeout(TIMEOUT_S):
        while not has_duty():
            await asyncio.sleep(0.01)


async def test_it_drives(kind: str) -> None:
    async with running("MobileBase", kind, ["watch D5", "watch D6"]) as stage:
        odom = await stage.listen("/odom", ODOM)
        joints = await stage.listen("/joint_states", "sensor_msgs/JointState")
        tf = await stage.listen("/tf", "tf/tfMessage")
        state = await stage.listen("/sensor_state", "turtlebot3_msgs/SensorState")
        cmd_vel = await stage.publisher("/cmd_vel", "geometry_msgs/Twist")
        async with driving(cmd_vel, 0.15, 0.5):
            await wait_for_duty(stage, "D5", (0.15 - 0.5 * WHEEL_SEPARATION / 2) / 0.22)
            await wait_for_duty(stage, "D6", (0.15 + 0.5 * WHEEL_SEPARATION / 2) / 0.22)
            moving = await odom.wait_for(lambda message: yaw_of(message.pose.pose.orientation) > 0.6)
        assert moving.twist.twist.linear.x == pytest.approx(0.15, abs=0.005)
        assert moving.twist.twist.angular.z == pytest.approx(0.5, abs=0.05)
        assert (moving.header.frame_id, moving.child_frame_id) == ("odom", "base_footprint")
        # It has moved along a circle with this radius.
        yaw, position = yaw_of(moving.pose.pose.orientation), moving.pose.pose.position
        assert position.x == pytest.approx(0.3 * math.sin(yaw), abs=0.01)
        assert position.y == pytest.approx(0.3 * (1 - math.cos(yaw)), abs=0.01)

        # No node commands it any more.
        stopped = await odom.wait_for(lambda message: message.twist.twist.linear.x == 0)
        await odom.wait_for()
        yaw = yaw_of(stopped.pose.pose.orientation)
        wheels = await joints.wait_for()
        assert list(wheels.name) == ["wheel_left_joint", "wheel_right_joint"]
        distance = (wheels.position[0] + wheels.position[1]) / 2 * WHEEL_RADIUS
        assert distance == pytest.approx(0.3 * yaw, abs=0.01)
        turned = (wheels.position[1] - wheels.position[0]) * WHEEL_RADIUS / WHEEL_SEPARATION
        assert turned == pytest.approx(yaw, abs=0.02)
        ticks = await state.wait_for()
        assert ticks.left_encoder == pytest.approx(wheels.position[0] * 4096 / math.tau, abs=1)
        assert ticks.right_encoder == pytest.approx(wheels.position[1] * 4096 / math.tau, abs=1)
        (frame,) = (await tf.wait_for()).transforms
        assert frame.transform.translation.x == stopped.pose.pose.position.x
        assert yaw_of(frame.transform.rotation) == pytest.approx(yaw)

        reset = await stage.publisher("/reset", "std_msgs/Empty")
        reset.publish()
        await odom.wait_for(lambda message: message.pose.pose.position.x == message.pose.pose.position.y == 0)


async def test_it_obeys_the_motor_switch_and_makes_sounds(kind: str) -> None:
    async with running("MobileBase", kind, ["watch D8"]) as stage:
        odom = await stage.listen("/odom", ODOM)
        power = await stage.publisher("/motor_power", "std_msgs/Bool")
        cmd_vel = await stage.publisher("/cmd_vel", "geometry_msgs/Twist")
        async with driving(cmd_vel, -0.1, 0):
            await odom.wait_for(lambda message: message.twist.twist.linear.x < -0.09)
            # If the commands come late on a busy machine, the motors stop until the next one.
            await stage.board.wait_for_pin("D4", True, timeout_s=TIMEOUT_S)
            await stage.board.wait_for_pin("D7", True, timeout_s=TIMEOUT_S)
            power.publish(data=False)
            await odom.wait_for(lambda message: message.twist.twist.linear.x == 0)
            assert (await stage.message("/sensor_state", "turtlebot3_msgs/SensorState")).torque is False
            power.publish(data=True)
            await odom.wait_for(lambda message: message.twist.twist.linear.x < -0.09)

        sound = await stage.publisher("/sound", "turtlebot3_msgs/Sound")
        sound.publish(value=4)
        rises_s: list[float] = []
        async with asyncio.timeout(TIMEOUT_S):
            # The tone lasts 0.1 s: it may end before this check.
            while len(rises_s) < 3:
                await asyncio.sleep(0.01)
                rises_s = [
                    each.time_s
                    for each in stage.board.recent
                    if each.name == "pin" and each["pin"] == "D8" and each["level"]
                ]
        assert rises_s[2] - rises_s[1] == pytest.approx(1 / 880, rel=0.02)


async def test_it_loses_no_command_while_it_publishes(kind: str) -> None:
    built = await build_example("MobileBase", kind)
    host = await ScriptedHost.start(built.elf, board=kind)
    ids: dict[str, int] = {}

    def answer(each: int, payload: bytes) -> None:
        if each == topic_id.TIME:
            host.send(topic_id.TIME, TIME)
        elif each == topic_id.SUBSCRIBER:
            info = TopicInfo.decode(payload)
            assert info is not None
            ids[info.topic_name] = info.topic_id

    host.on_frame = answer
    async with host.board:
        host.send(topic_id.TOPIC_REQUEST)
        assert await host.run(3000, lambda: "motor_power" in ids)
        # Each burst comes at a different time of the board's period of 100 ms. It is longer than the UART's
        # buffer. While the board publishes, it has room for a burst and the answer to a time request.
        for number in range(25):
            is_on = number % 2
            host.send(ids["cmd_vel"], struct.pack("<6d", 0.1, 0, 0, 0, 0, 0))
            for each in (1 - is_on, 1 - is_on, is_on):
                host.send(ids["motor_power"], bytes([each]))
            await host.run(104)
            assert await host.board.memory("has_power", 1) == bytes([is_on]), number


async def test_it_publishes_its_sensors(kind: str) -> None:
    commands = ["adc A0=4.0", "pin D9=0", "attitude 0 0 30"]
    async with running("MobileBase", kind, commands) as stage:
        state = await stage.message("/sensor_state", "turtlebot3_msgs/SensorState")
        assert state.bumper == 1
        assert state.battery == pytest.approx(12, abs=0.02)
        battery = await stage.message(
            "/battery_state", "sensor_msgs/BatteryState", lambda message: message.voltage > 1
        )
        assert battery.voltage == pytest.approx(12, abs=0.02)
        assert battery.percentage == pytest.approx(1.0 / 1.4, abs=0.02)
        assert battery.present
        version = await stage.message("/version_info", "turtlebot3_msgs/VersionInfo")
        assert (version.hardware, version.firmware) == ("Arduino", "1.0")
        imu = await stage.message("/imu", "sensor_msgs/Imu")
        assert imu.linear_acceleration.z == pytest.approx(9.81, abs=0.05)
        # The simulated magnetic field of the Earth: 20 microtesla to the north, 44 down.
        field = await stage.message("/magnetic_field", "sensor_msgs/MagneticField")
        found = (field.magnetic_field.x, field.magnetic_field.y, field.magnetic_field.z)
        north, west = 20e-6 * math.cos(math.pi / 6), -20e-6 * math.sin(math.pi / 6)
        assert found == pytest.approx((north, west, -44e-6), abs=0.4e-6)
        assert await stage.board.free_stack_bytes() > 100


async def test_it_works_without_an_imu() -> None:
    async with running("MobileBase", commands=["adc A0=3.8"]) as stage:
        await stage.message("/odom", ODOM)
        rates = await stage.listen("/odom", ODOM)
        for _ in range(TRIES):
            stamps = [message.header.stamp.to_s() for message in await rates.next_messages(15)]
            period_s = (stamps[-1] - stamps[3]) / 11
            # On a busy machine, the board's clock is set while it counts.
            if period_s == pytest.approx(0.1, rel=0.1):
                break
        assert period_s == pytest.approx(0.1, rel=0.1)
