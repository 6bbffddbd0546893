"""Simulated servos: packets on a bus with its own clock."""

from __future__ import annotations

import math

import pytest

from rostether.simulation.dynamixel.control_table import BY_NAME
from rostether.simulation.dynamixel.packets import (
    ALERT,
    BROADCAST_ID,
    Instruction,
    PacketReader,
    ServoError,
    encode_packet,
)
from rostether.simulation.dynamixel.servo import RAD_S_PER_UNIT, TICKS_PER_RAD
from rostether.simulation.dynamixel.servo_bus import ServoBus

TURN_RAD_S = 100 * RAD_S_PER_UNIT


class Controller:
    """Sends requests to the servos 1 and 2."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.bus = ServoBus((1, 2), lambda: self.now_s)

    def ask(self, servo_id: int, instruction: int, parameters: bytes = b"") -> list[tuple[int, int, bytes]]:
        """Return id, error and data of all answers."""
        answer = self.bus.receive(encode_packet(servo_id, instruction, parameters))
        return [(each.id, each.parameters[0], each.parameters[1:]) for each in PacketReader().feed(answer)]

    def write(self, servo_id: int, name: str, value: int) -> int:
        """Write a register; return the error."""
        register = BY_NAME[name]
        data = value.to_bytes(register.size, "little", signed=value < 0)
        ((_, error, _),) = self.ask(servo_id, Instruction.WRITE, _address(name) + data)
        return error

    def read(self, servo_id: int, name: str) -> int:
        """Read a register."""
        register = BY_NAME[name]
        size = register.size.to_bytes(2, "little")
        ((_, _, data),) = self.ask(servo_id, Instruction.READ, _address(name) + size)
        return int.from_bytes(data, "little", signed=register.is_signed)

    def drive(self, speed: int) -> None:
        """Set the speed of both servos, and wait until they have reached it."""
        for servo_id in (1, 2):
            assert self.write(servo_id, "torque_enable", 0) == 0
            assert self.write(servo_id, "operating_mode", 1) == 0
            assert self.write(servo_id, "torque_enable", 1) == 0
        values = b"".join(bytes((each,)) + speed.to_bytes(4, "little", signed=True) for each in (1, 2))
        assert (
            self.ask(BROADCAST_ID, Instruction.SYNC_WRITE, _address("goal_velocity") + b"\4\0" + values) == []
        )


def _address(name: str) -> bytes:
    return BY_NAME[name].address.to_bytes(2, "little")


def test_servos_answer_a_ping_with_their_model() -> None:
    controller = Controller()
    answers = controller.ask(BROADCAST_ID, Instruction.PING)
    assert [(each, error, int.from_bytes(data[:2], "little")) for each, error, data in answers] == [
        (1, 0, 1060),
        (2, 0, 1060),
    ]
    assert controller.ask(3, Instruction.PING) == []


def test_a_wheel_turns_at_the_commanded_speed_and_stops_without_torque() -> None:
    controller = Controller()
    controller.drive(-100)
    ramp_s = TURN_RAD_S / 60
    controller.now_s += ramp_s / 2
    assert controller.read(1, "present_velocity") == -50
    assert controller.read(1, "present_load") < 0
    controller.now_s += 2 - ramp_s / 2
    assert controller.read(2, "present_velocity") == -100
    assert controller.read(2, "moving") == 1
    angle_rad = -TURN_RAD_S * (2 - ramp_s / 2)
    assert controller.read(2, "present_position") == math.floor(angle_rad * TICKS_PER_RAD)
    # Both at once: position and velocity in the order of the request.
    sync = _address("present_velocity") + b"\x08\0" + bytes((2, 1))
    answers = controller.ask(BROADCAST_ID, Instruction.SYNC_READ, sync)
    assert [each for each, _, _ in answers] == [2, 1]
    assert int.from_bytes(answers[0][2][:4], "little", signed=True) == -100

    assert controller.write(1, "torque_enable", 0) == 0
    controller.now_s += 1
    assert controller.read(1, "present_velocity") == 0
    assert controller.read(2, "present_velocity") == -100


def test_a_long_step_equals_many_short_ones() -> None:
    ways = []
    for steps in (1, 500):
        controller = Controller()
        controller.drive(200)
        for _ in range(steps):
            controller.now_s += 5 / steps
            controller.bus.advance()
        ways.append(controller.bus.servos[1].motor.angle_rad)
    assert ways[0] == pytest.approx(ways[1], abs=1e-9)


def test_invalid_requests_are_refused() -> None:
    controller = Controller()
    controller.drive(0)
    assert controller.write(1, "operating_mode", 3) == ServoError.ACCESS
    assert controller.write(1, "present_position", 0) == ServoError.ACCESS
    assert controller.write(1, "goal_velocity", 266) == ServoError.DATA_LIMIT
    assert controller.write(1, "led", 2) == ServoError.DATA_RANGE
    assert controller.ask(1, Instruction.WRITE, _address("goal_velocity") + b"\1") == [
        (1, ServoError.DATA_LENGTH, b"")
    ]
    assert controller.ask(1, Instruction.READ, b"\x90\0\xff\0") == [(1, ServoError.DATA_RANGE, b"")]
    assert controller.ask(1, Instruction.ACTION) == [(1, ServoError.RESULT_FAIL, b"")]
    assert controller.ask(1, 0x77) == [(1, ServoError.INSTRUCTION, b"")]
    # A missing servo ends a sync read: the servos after it wait for its answer.
    sync = _address("led") + b"\1\0" + bytes((1, 3, 2))
    assert [each for each, _, _ in controller.ask(BROADCAST_ID, Instruction.SYNC_READ, sync)] == [1]


def test_the_watchdog_stops_a_servo_without_commands() -> None:
    controller = Controller()
    controller.drive(100)
    assert controller.write(1, "bus_watchdog", 10) == 0
    controller.now_s += 0.19
    assert controller.read(1, "present_velocity") == 100
    before_rad = controller.bus.servos[1].motor.angle_rad
    controller.now_s += 10
    assert controller.read(1, "present_velocity") == 0
    braking_rad = TURN_RAD_S**2 / 60 / 2
    way_rad = controller.bus.servos[1].motor.angle_rad - before_rad
    assert way_rad == pytest.approx(0.2 * TURN_RAD_S + braking_rad)
    assert controller.write(1, "goal_velocity", 100) == ServoError.DATA_RANGE
    assert controller.write(1, "bus_watchdog", 0) == 0
    assert controller.write(1, "goal_velocity", 100) == 0


def test_a_hardware_error_switches_the_torque_off_until_a_reboot() -> None:
    controller = Controller()
    controller.drive(100)
    # Overload.
    controller.bus.servos[2].fail(0x20)
    assert controller.write(2, "led", 1) == ALERT
    assert controller.read(2, "torque_enable") == 0
    assert controller.write(2, "torque_enable", 1) == ALERT | ServoError.RESULT_FAIL
    # A voltage error is only reported.
    controller.bus.servos[1].set_voltage(5.5)
    assert controller.write(1, "led", 1) == ALERT
    assert controller.read(1, "torque_enable") == 1

    assert controller.ask(2, Instruction.REBOOT) == [(2, 0, b"")]
    assert controller.ask(2, Instruction.PING) == []
    controller.now_s += 0.3
    assert controller.write(2, "torque_enable", 1) == 0


def test_registered_writes_start_together() -> None:
    controller = Controller()
    controller.drive(0)
    goal = _address("goal_velocity") + (50).to_bytes(4, "little")
    for servo_id in (1, 2):
        assert controller.ask(servo_id, Instruction.REG_WRITE, goal) == [(servo_id, 0, b"")]
        assert controller.read(servo_id, "goal_velocity") == 0
    assert controller.ask(BROADCAST_ID, Instruction.ACTION) == []
    assert [controller.read(servo_id, "goal_velocity") for servo_id in (1, 2)] == [50, 50]


def test_answers_can_be_lost() -> None:
    controller = Controller()
    answers: list[bytes] = []

    def drop(answer: bytes) -> bytes:
        answers.append(answer)
        return b""

    controller.bus.damage = drop
    assert controller.ask(1, Instruction.PING) == []
    assert len(answers) == 1
