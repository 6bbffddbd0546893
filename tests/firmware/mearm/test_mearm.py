"""The MeArm, end to end: the commands of its description, the servos of the board, and the frames of the
model.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from contextlib import AsyncExitStack, aclosing
from pathlib import Path
from typing import Any

import pytest

from firmware.examples.stage import open_graph
from firmware.mearm.terminal import EXAMPLE, Terminals, terminals
from robot_poses import forward_kinematics
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions
from rostether.graph.typed_graph import TypedGraph
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_messages import from_message
from rostether.robot.urdf import parse_urdf
from rostether.ros1.master.server import MasterServer
from rostether.simulation.simavr.simulated_board import SimulatedBoard

PINS = ("D9", "D10", "D11", "D12")
SERVOS = ("servo1", "servo2", "servo3", "servo4")
SKETCH = EXAMPLE / "mearm_model" / "sketch" / "mearm_servos"
MODEL = EXAMPLE / "mearm_model" / "urdf" / "robot.urdf.xacro"
SET3 = (-0.25, 0.0, 0.25, 0.5)
# Interrupts make a pulse up to half a degree longer.
JITTER_DEGREES = 1.0

Matrix = list[list[float]]


def angles_of(message: Any) -> tuple[int, ...]:
    return tuple(getattr(message, name) for name in SERVOS)


async def wait_for_angles(graph: TypedGraph, topic: str, expected: Sequence[int]) -> None:
    """Wait for a message with these servo angles."""
    seen = None
    try:
        async with asyncio.timeout(60), aclosing(aiter(graph.messages(topic))) as messages:
            async for message in messages:
                seen = angles_of(message)
                if seen == tuple(expected):
                    return
    except TimeoutError:
        pytest.fail(f"no message on {topic} had the angles {expected}; the last one had {seen}")


async def wait_for_servos(board: SimulatedBoard, expected: Sequence[float]) -> None:
    angles: list[float] = []
    try:
        async with asyncio.timeout(60):
            while (
                not angles or max(abs(a - b) for a, b in zip(angles, expected, strict=True)) > JITTER_DEGREES
            ):
                angles = [await board.servo_angle(pin) for pin in PINS]
                await asyncio.sleep(0.01)
    except TimeoutError:
        pytest.fail(f"the servos did not reach {expected}; they are at {angles}")


async def wait_for_frames(graph: TypedGraph, child: str, turn: float) -> TransformBuffer:
    """Return the frames as soon as a joint's link is turned by this angle about z."""
    buffer = TransformBuffer()
    async with asyncio.timeout(60):
        static = await graph.wait_for_message("/tf_static", "tf2_msgs/TFMessage")
        async with aclosing(aiter(graph.messages("/tf", "tf2_msgs/TFMessage"))) as messages:
            async for message in messages:
                found = {each.child: each.transform.rotation for each in from_message(message)}
                if child in found and abs(found[child][2] - math.sin(turn / 2)) < 1e-9:
                    break
    for each in from_message(static):
        assert not buffer.set_transform(each, is_static=True)
    for each in from_message(message):
        assert not buffer.set_transform(each)
    return buffer


def product(*matrices: Matrix) -> Matrix:
    result = [[float(row == column) for column in range(4)] for row in range(4)]
    for matrix in matrices:
        result = [
            [sum(result[row][k] * matrix[k][column] for k in range(4)) for column in range(4)]
            for row in range(4)
        ]
    return result


def translation_matrix(x: float, y: float, z: float) -> Matrix:
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def rotation_about_z(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def rotation_about_y(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return [[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]]


def finger_pose(joints: Sequence[float]) -> Matrix:
    """Return the pose of the finger in base_link, calculated from the drawing of the arm."""
    return product(
        translation_matrix(0, 0, 0.04),
        rotation_about_z(joints[0]),
        translation_matrix(0.01, 0, 0.025),
        rotation_about_y(joints[1]),
        translation_matrix(0, 0, 0.08),
        rotation_about_y(joints[2]),
        translation_matrix(0.08, 0, 0),
        translation_matrix(0, -0.012, 0),
        rotation_about_z(-joints[3]),
    )


async def check_frames(graph: TypedGraph) -> None:
    buffer = await wait_for_frames(graph, "turret", SET3[0])
    model = parse_urdf(MODEL.read_text())
    positions = {f"joint_{number}": position for number, position in enumerate(SET3)}
    for link, pose in forward_kinematics(model, positions).items():
        found = buffer.lookup("base_link", link).transform
        assert found.translation == pytest.approx(pose.translation, abs=1e-9)
        assert found.rotation == pytest.approx(pose.rotation, abs=1e-9)
    pose_of_finger = finger_pose(SET3)
    finger = buffer.lookup("base_link", "finger").transform
    for point in ((0.0, 0.0, 0.0), (0.06, 0.0, 0.0), (0.0, 0.01, 0.02)):
        expected = [
            sum(pose_of_finger[row][k] * value for k, value in enumerate((*point, 1))) for row in range(3)
        ]
        assert finger.apply(point) == pytest.approx(expected, abs=1e-9)


async def select(terminal: Terminals, name: str) -> str:
    return await terminal.type(f"rosservice call /select_position_set \"set_name: '{name}'\"")


@pytest.mark.parametrize("remapping", ["", "servo_control:=servo_pose_server"])
async def test_named_positions_move_servos_and_model(tmp_path: Path, remapping: str) -> None:
    built = await build_sketch(SKETCH, find_board("uno"), BuildOptions(warnings=True))
    assert built.output == ""
    port = tmp_path / "ttyACM0"
    async with AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        graph = await stack.enter_async_context(open_graph(master.uri))
        board = await stack.enter_async_context(
            await SimulatedBoard.start(built.elf, board="uno", link_path=port)
        )
        terminal = await stack.enter_async_context(terminals(tmp_path, master.uri))
        launch = await terminal.start("roslaunch mearm_move service.launch")
        bridge = await terminal.start(
            f"rosrun rosserial_python serial_node.py _port:={port} _baud:=115200 {remapping}"
        )
        await bridge.wait_for("Setup publisher on servo_angles [mearm_model/ServoAngles]")
        await wait_for_servos(board, (0, 0, 0, 0))

        assert await select(terminal, "set3") == "success: True"
        await wait_for_angles(graph, "/servo_pose_server", (-14, 0, 14, 29))
        await wait_for_servos(board, (0, 0, 14, 29))
        await wait_for_angles(graph, "/servo_angles", (0, 0, 14, 29))
        await check_frames(graph)

        assert await select(terminal, "set2") == "success: False"
        await launch.wait_for("Position set set2 is refused: it has 3 values, but the arm has 4 joints")
        assert await terminal.type('rosservice call /set_servo_pose "position_id: 1"') == "success: True"
        await wait_for_servos(board, (45, 120, 60, 10))
        await wait_for_angles(graph, "/servo_angles", (45, 120, 60, 10))
