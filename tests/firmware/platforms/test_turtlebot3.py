"""The firmware of a TurtleBot3 Burger on a simulated OpenCR, with the real bridge."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import math
from collections.abc import AsyncIterator, Callable, Container
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from firmware.examples.attitudes import yaw_of
from firmware.platforms.node_harness import TIMEOUT_S, NodeHarness, node_harness
from firmware.platforms.programs import EXAMPLES
from rostether.errors import SketchError
from rostether.firmware.opencr_build import build_for_linux
from rostether.serde.values import Message
from rostether.simulation.dynamixel.packets import Instruction
from rostether.simulation.opencr.board import OpenCrBoard
from rostether.simulation.opencr.pins import pin_number
from waiting import until

pytestmark = pytest.mark.gcc

SKETCH = EXAMPLES / "TurtleBot3Burger"
TWIST, ODOM, STATE = "geometry_msgs/Twist", "nav_msgs/Odometry", "turtlebot3_msgs/SensorState"
SIDE_M = 0.2


@pytest.fixture(scope="module")
def program() -> Path:
    """The firmware as a Linux program."""
    return asyncio.run(build_for_linux(SKETCH))


class Robot:
    """The board, and a program on the graph of its bridge."""

    def __init__(self, board: OpenCrBoard, harness: NodeHarness) -> None:
        self.board = board
        self.harness = harness

    async def message(
        self, topic: str, type_name: str, condition: Callable[[Any], object] = lambda _message: True
    ) -> Message:
        """Return the next message of a topic that meets a condition."""
        async with asyncio.timeout(TIMEOUT_S):
            async for message in self.harness.graph.messages(topic, type_name):
                if condition(message):
                    return message
        raise AssertionError("the graph has ended")

    async def publish(self, topic: str, type_name: str, **fields: Any) -> None:
        """Publish one message to the board."""
        publisher = await self.harness.graph.publisher(topic, type_name)
        assert await publisher.wait_for_subscriber(TIMEOUT_S), f"the board does not subscribe to {topic}"
        publisher.publish(**fields)

    async def drive_until(self, speed: float, turn_rate: float, condition: Callable[[Any], object]) -> None:
        """Command a speed until an odometry message meets a condition, then wait until the robot is at
        rest.
        """
        publisher = await self.harness.graph.publisher("/cmd_vel", TWIST)
        assert await publisher.wait_for_subscriber(TIMEOUT_S)
        async with asyncio.timeout(TIMEOUT_S):
            async for message in self.harness.graph.messages("/odom", ODOM):
                if condition(message.pose.pose):
                    break
                publisher.publish(linear={"x": speed}, angular={"z": turn_rate})
        publisher.publish(linear={"x": 0.0})
        await self.message("/odom", ODOM, is_at_rest)


def is_at_rest(message: Any) -> bool:
    return bool(message.twist.twist.linear.x == message.twist.twist.angular.z == 0)


def has_driven_a_side(start: Any, pose: Any) -> bool:
    return math.dist((pose.position.x, pose.position.y), (start.x, start.y)) > SIDE_M - 0.01


def has_turned(heading: float, pose: Any) -> bool:
    return math.remainder(heading - yaw_of(pose.orientation), math.tau) < 0.08


@contextlib.asynccontextmanager
async def start_burger(
    program: Path, lost_answers: Container[int] = (), **parameters: Any
) -> AsyncIterator[Robot]:
    """Start the robot with private parameters. `lost_answers` are the numbers of the servos' lost answers."""
    async with node_harness() as harness, await OpenCrBoard.start(program) as board:
        answers = itertools.count()
        board.base.damage = lambda answer: b"" if next(answers) in lost_answers else answer
        for key, value in parameters.items():
            await harness.graph.set_param(f"/burger/{key}", value)
        async with harness.bridge(f"{board.address}?name=burger"):
            yield Robot(board, harness)


async def test_it_drives_a_square_with_correct_odometry(program: Path) -> None:
    async with start_burger(program) as robot:
        base = robot.board.base
        for side in range(4):
            start = (await robot.message("/odom", ODOM, is_at_rest)).pose.pose.position
            start_position = base.x_m, base.y_m
            await robot.drive_until(0.2, 0, partial(has_driven_a_side, start))
            await robot.drive_until(0, 2.0, partial(has_turned, (side + 1) * math.pi / 2))
            pose = (await robot.message("/odom", ODOM, is_at_rest)).pose.pose
            base.advance()
            # On a busy machine it stops late; its odometry is still correct.
            assert math.dist((base.x_m, base.y_m), start_position) > SIDE_M - 0.02
            assert math.dist((pose.position.x, pose.position.y), (base.x_m, base.y_m)) < 0.01
            assert abs(math.remainder(yaw_of(pose.orientation) - base.heading_rad, math.tau)) < 0.01
        (frame,) = (await robot.message("/tf", "tf/tfMessage")).transforms
        assert (frame.header.frame_id, frame.child_frame_id) == ("odom", "base_footprint")
        assert frame.transform.translation.x == pytest.approx(pose.position.x)
        joints = await robot.message("/joint_states", "sensor_msgs/JointState")
        assert list(joints.name) == ["wheel_left_joint", "wheel_right_joint"]
        motors = [servo.motor.angle_rad for servo in base.servos.values()]
        assert list(joints.position) == pytest.approx(motors, abs=0.01)

        # A command is valid for half a second. The servos accept at most 265 units.
        driving = asyncio.ensure_future(
            robot.message("/odom", ODOM, lambda each: each.twist.twist.linear.x > 0.15)
        )
        await robot.publish("/cmd_vel", TWIST, linear={"x": 1.0}, angular={"z": 0.0})
        await driving
        assert base.speed_m_s < 0.22
        await robot.message("/odom", ODOM, is_at_rest)
        await robot.publish("/reset", "std_msgs/Empty")
        await robot.message("/odom", ODOM, lambda each: each.pose.pose.position.x == 0)


async def test_it_publishes_its_sensors(program: Path) -> None:
    async with start_burger(program, tf_prefix="tb3_0") as robot:
        board = robot.board
        board.set_pin("BDPIN_PUSH_SW_1", high=True)
        board.set_pin("OLLO_4", high=True)
        board.set_voltage("OLLO_2", 1.65)
        board.set_voltage("A1", 0.33)
        board.set_range(0.5)
        board.set_battery(10.8)
        state = await robot.message("/sensor_state", STATE, lambda each: each.sonar > 1 and each.torque)
        assert (state.button, state.bumper) == (1, 1)
        assert (state.cliff, state.illumination) == (512, 102)
        assert state.sonar == pytest.approx(50, abs=0.1)
        assert state.battery == pytest.approx(10.8, abs=0.02)
        # Its LEDs: connected, low battery.
        await until(lambda: board.pins.get(pin_number("LED_USER_2")) is False, "the low battery's LED")
        assert board.pins[pin_number("LED_USER_1")] is False

        def is_low(message: Any) -> bool:
            parts = {each.name: each for each in message.status}
            return (parts["Power System"].level, parts["Actuator"].values[0].value) == (1, "10.8 V")

        await robot.message("/diagnostics", "diagnostic_msgs/DiagnosticArray", is_low)
        battery = await robot.message("/battery_state", "sensor_msgs/BatteryState")
        assert (battery.percentage, battery.present) == (0, True)
        imu = await robot.message("/imu", "sensor_msgs/Imu", lambda each: each.header.frame_id)
        assert imu.header.frame_id == "tb3_0/imu_link"
        assert imu.linear_acceleration.z == pytest.approx(9.807, abs=0.002)
        field = (await robot.message("/magnetic_field", "sensor_msgs/MagneticField")).magnetic_field
        assert (field.x, field.y, field.z) == pytest.approx((20e-6, 0, -44e-6), abs=0.2e-6)

        # The remote control turns it while packets arrive.
        turning = asyncio.ensure_future(
            robot.message("/imu", "sensor_msgs/Imu", lambda each: each.angular_velocity.z > 0.9)
        )
        held = asyncio.ensure_future(robot.message("/cmd_vel_rc100", TWIST, lambda each: each.angular.z == 1))
        while not (turning.done() and held.done()):
            board.send_remote_buttons(4)
            await asyncio.sleep(0.1)
        assert (await turning).angular_velocity.z == pytest.approx(1, abs=0.1)
        await robot.message("/odom", ODOM, is_at_rest)

        await robot.publish("/sound", "turtlebot3_msgs/Sound", value=4)
        await until(lambda: board.tones, "a tone")
        assert board.tones[0] == (880, 100)


async def test_it_stops_without_a_sender(program: Path) -> None:
    async with start_burger(program) as robot:
        board = robot.board
        commands = await robot.harness.graph.publisher("/cmd_vel", TWIST)
        assert await commands.wait_for_subscriber(TIMEOUT_S)

        def command(speed: float) -> None:
            commands.publish(linear={"x": speed})

        async def repeat(send: Callable[[], None], condition: Callable[[], bool]) -> None:
            async with asyncio.timeout(TIMEOUT_S):
                while not condition():
                    send()
                    await asyncio.sleep(0.05)

        def is_moving() -> bool:
            return board.base.speed_m_s > 0.05

        def is_stopped() -> bool:
            return board.base.speed_m_s == 0

        # The remote control is lost while a computer commands speed 0.
        await repeat(partial(board.send_remote_buttons, 1), is_moving)
        await repeat(partial(command, 0.0), is_stopped)
        # The computer is lost while the remote control sends that no button is pressed.
        await repeat(partial(command, 0.1), is_moving)
        await repeat(partial(board.send_remote_buttons, 0), is_stopped)
        # NaN is not a speed.
        await repeat(partial(command, 0.1), is_moving)
        await repeat(partial(command, math.nan), is_stopped)


async def test_torque_and_errors_of_the_servos(program: Path) -> None:
    # The left servo does not answer at first, and is set up later.
    async with start_burger(program, lost_answers=(0,)) as robot:
        base = robot.board.base
        await robot.message("/sensor_state", STATE, lambda each: each.torque)
        await until(lambda: base.servos[1]["operating_mode"] == 1, "velocity mode")
        await robot.publish("/motor_power", "std_msgs/Bool", data=False)
        await robot.message("/sensor_state", STATE, lambda each: not each.torque)
        assert [servo["torque_enable"] for servo in base.servos.values()] == [0, 0]

        # The robot is pushed by hand, then loses its power briefly: the servo loses its count of turns.
        servo = base.servos[2]
        servo.motor.angle_rad = 30.0
        pushed = (
            await robot.message("/odom", ODOM, lambda each: each.pose.pose.orientation.z != 0)
        ).pose.pose
        servo.handle(Instruction.REBOOT, b"", asyncio.get_running_loop().time())
        ticks = math.floor(30.0 % math.tau * 4096 / math.tau)
        await robot.message("/sensor_state", STATE, lambda each: each.right_encoder == ticks)
        assert (await robot.message("/odom", ODOM)).pose.pose == pushed
        await until(lambda: servo["bus_watchdog"], "the watchdog after a restart")

        # Overloaded.
        base.servos[2].fail(0x20)

        def has_failed(message: Any) -> bool:
            (part,) = [each for each in message.status if each.name == "Actuator"]
            return (part.level, part.message) == (2, "the right servo has a hardware error: 0x20")

        await robot.message("/diagnostics", "diagnostic_msgs/DiagnosticArray", has_failed)
        await robot.publish("/motor_power", "std_msgs/Bool", data=True)
        await until(lambda: base.servos[2]["torque_enable"] == 1, "the torque after a restart")
        assert base.servos[2]["hardware_error_status"] == 0

        # While the line damages each answer, the robot reports it; after that it works again.
        base.damage = lambda answer: answer[:-1] + bytes((answer[-1] ^ 1,))
        is_silent = "a servo does not answer"
        await robot.message(
            "/diagnostics",
            "diagnostic_msgs/DiagnosticArray",
            lambda message: is_silent in [each.message for each in message.status],
        )
        base.damage = None
        await robot.message("/odom", ODOM)


async def test_a_sketch_with_an_error_is_reported_with_its_lines(tmp_path: Path) -> None:
    sketch = tmp_path / "wrong.ino"
    sketch.write_text("void setup() { pinMode(BDPIN_LED_USER_1, OUTPUT); }\nvoid loop() { missing(); }\n")
    with pytest.raises(SketchError) as raised:
        await build_for_linux(sketch)
    assert "wrong.ino:2:" in raised.value.diagnostics
