"""A simulated DYNAMIXEL XL430-W250 in velocity mode: a control table in front of a motor."""

from __future__ import annotations

import math

from rostether.simulation.dynamixel.control_table import (
    BY_NAME,
    FIRMWARE,
    MODEL,
    RAM_START,
    REGISTERS,
    TABLE_BYTES,
    Register,
)
from rostether.simulation.dynamixel.packets import ALERT, Instruction, ServoError

VELOCITY_MODE = 1
RAD_S_PER_UNIT = 0.229 * math.tau / 60
TICKS_PER_RAD = 4096 / math.tau
# Units of the profile: 214.577 turns per minute squared.
PROFILE_RAD_S2 = 214.577 * math.tau / 3600
WATCHDOG_UNIT_S = 0.02
# The time after a reboot in which a servo does not answer.
REBOOT_S = 0.2
_GOALS = ("goal_pwm", "goal_velocity", "goal_position")

# An XL430 without load reaches 6 rad/s within 0.1 s.
ACCELERATION_RAD_S2 = 60.0


class Servo:
    """One servo. All times are in seconds of the bus's clock; `motor` turns the wheel."""

    def __init__(self, servo_id: int, now_s: float) -> None:
        self.motor = WheelMotor(now_s)
        self._table = bytearray(TABLE_BYTES)
        for register in REGISTERS:
            self._set(register, register.initial)
        self._set(BY_NAME["id"], servo_id)
        self._registered: bytes | None = None
        self._last_packet_s = now_s
        self._restarting_until_s = now_s
        self._now_s = now_s

    @property
    def id(self) -> int:
        """The servo's address on the bus."""
        return self["id"]

    def __getitem__(self, name: str) -> int:
        """Return a register's value by its name; measurements are those of the last `advance`."""
        register = BY_NAME[name]
        data = self._table[register.address : register.address + register.size]
        return int.from_bytes(data, "little", signed=register.is_signed)

    def is_restarting(self, now_s: float) -> bool:
        """Return whether it is restarting and therefore receives nothing."""
        return now_s < self._restarting_until_s

    def set_voltage(self, volts: float) -> None:
        """Change the supply voltage. Outside its limits, the servo reports an input voltage error."""
        tenths = round(volts * 10)
        self._set(BY_NAME["present_input_voltage"], tenths)
        if not self["min_voltage_limit"] <= tenths <= self["max_voltage_limit"]:
            self.fail(0x01)

    def fail(self, hardware_error: int) -> None:
        """Report a hardware error (bits); the bits in the register `shutdown` switch the torque off."""
        self._set(BY_NAME["hardware_error_status"], self["hardware_error_status"] | hardware_error)
        if hardware_error & self["shutdown"]:
            self._set(BY_NAME["torque_enable"], 0)

    def advance(self, now_s: float) -> None:
        """Move up to `now_s`, and update the measurements."""
        watchdog = self["bus_watchdog"]
        stop_s = self._last_packet_s + watchdog * WATCHDOG_UNIT_S
        if watchdog > 0 and self["torque_enable"] and now_s > stop_s:
            self._move(max(self._now_s, stop_s))
            self._set(BY_NAME["bus_watchdog"], -1)
            self._set(BY_NAME["goal_velocity"], 0)
        self._move(now_s)

    def restart_watchdog(self, now_s: float) -> None:
        """Restart the bus watchdog, because a packet arrived."""
        self._last_packet_s = now_s

    def handle(self, instruction: int, parameters: bytes, now_s: float) -> tuple[int, bytes]:
        """Execute an instruction to this servo only; return the status packet's error and data."""
        error, data = self._handle(instruction, parameters, now_s)
        return error | (ALERT if self["hardware_error_status"] else 0), data

    def read(self, address: int, size: int) -> tuple[int, bytes]:
        """Return the error (a ServoError) and the bytes of the registers."""
        if size == 0 or address + size > TABLE_BYTES:
            return ServoError.DATA_RANGE, b""
        return ServoError.NONE, bytes(self._table[address : address + size])

    def write(self, address: int, data: bytes) -> int:
        """Write complete registers, all or none; return the error (a ServoError)."""
        changes: list[tuple[Register, int]] = []
        position = 0
        while position < len(data):
            register = _register_at(address + position)
            if register is None or position + register.size > len(data):
                return ServoError.DATA_LENGTH if register else ServoError.DATA_RANGE
            value = int.from_bytes(
                data[position : position + register.size], "little", signed=register.is_signed
            )
            error = self._refusal(register, value)
            if error:
                return error
            changes.append((register, value))
            position += register.size
        for register, value in changes:
            self._set(register, value)
            if register.name in ("torque_enable", "operating_mode"):
                self._set(BY_NAME["goal_velocity"], 0)
        return ServoError.NONE if changes else ServoError.DATA_LENGTH

    def _handle(self, instruction: int, parameters: bytes, now_s: float) -> tuple[int, bytes]:
        match instruction:
            case Instruction.PING:
                return ServoError.NONE, MODEL.to_bytes(2, "little") + bytes((FIRMWARE,))
            case Instruction.READ if len(parameters) == 4:
                return self.read(_word(parameters, 0), _word(parameters, 2))
            case Instruction.WRITE if len(parameters) > 2:
                return self.write(_word(parameters, 0), parameters[2:]), b""
            case Instruction.REG_WRITE if len(parameters) > 2:
                self._registered = parameters
                self._set(BY_NAME["registered_instruction"], 1)
            case Instruction.ACTION:
                return self._write_registered(), b""
            case Instruction.REBOOT:
                self._reboot(now_s)
            case Instruction.READ | Instruction.WRITE | Instruction.REG_WRITE:
                return ServoError.DATA_LENGTH, b""
            case _:
                return ServoError.INSTRUCTION, b""
        return ServoError.NONE, b""

    def _write_registered(self) -> int:
        if self._registered is None:
            return ServoError.RESULT_FAIL
        parameters, self._registered = self._registered, None
        self._set(BY_NAME["registered_instruction"], 0)
        return self.write(_word(parameters, 0), parameters[2:])

    def _refusal(self, register: Register, value: int) -> int:
        if not register.is_writable:
            return ServoError.ACCESS
        if register.address < RAM_START and self["torque_enable"]:
            return ServoError.ACCESS
        if register.name in _GOALS and self["bus_watchdog"] < 0:
            return ServoError.DATA_RANGE
        if register.name == "goal_velocity" and abs(value) > self["velocity_limit"]:
            return ServoError.DATA_LIMIT
        if not register.lowest <= value <= register.highest:
            return ServoError.DATA_RANGE
        if register.name == "torque_enable" and value and self["hardware_error_status"] & self["shutdown"]:
            return ServoError.RESULT_FAIL
        return ServoError.NONE

    def _move(self, now_s: float) -> None:
        is_driven = self["torque_enable"] and self["operating_mode"] == VELOCITY_MODE
        # Without torque the gear brakes the wheel.
        self.motor.goal_rad_s = self["goal_velocity"] * RAD_S_PER_UNIT if is_driven else 0.0
        profile = self["profile_acceleration"] * PROFILE_RAD_S2
        self.motor.acceleration_rad_s2 = min(profile, ACCELERATION_RAD_S2) or ACCELERATION_RAD_S2
        self.motor.advance(now_s)
        self._now_s = now_s
        ticks = math.floor(self.motor.angle_rad * TICKS_PER_RAD)
        velocity = round(self.motor.speed_rad_s / RAD_S_PER_UNIT)
        self._set(BY_NAME["present_position"], (ticks + 2**31) % 2**32 - 2**31)
        self._set(BY_NAME["present_velocity"], velocity)
        self._set(BY_NAME["velocity_trajectory"], velocity)
        self._set(BY_NAME["present_load"], round(self.motor.effort * 1000))
        self._set(BY_NAME["moving"], int(abs(velocity) > self["moving_threshold"]))
        self._set(BY_NAME["realtime_tick"], int(now_s * 1000) % 32768)

    def _reboot(self, now_s: float) -> None:
        for register in REGISTERS:
            if register.address >= RAM_START and not register.name.startswith("present_"):
                self._set(register, register.initial)
        self._registered = None
        # A reboot loses the number of turns.
        self.motor.angle_rad %= math.tau
        self._restarting_until_s = now_s + REBOOT_S

    def _set(self, register: Register, value: int) -> None:
        data = value.to_bytes(register.size, "little", signed=register.is_signed)
        self._table[register.address : register.address + register.size] = data


def _register_at(address: int) -> Register | None:
    return next((register for register in REGISTERS if register.address == address), None)


def _word(data: bytes, offset: int) -> int:
    return int.from_bytes(data[offset : offset + 2], "little")


class WheelMotor:
    """One wheel: `angle_rad` and `speed_rad_s` at the time of the last `advance`."""

    def __init__(self, now_s: float) -> None:
        self.angle_rad = 0.0
        self.speed_rad_s = 0.0
        self.goal_rad_s = 0.0
        self.acceleration_rad_s2 = ACCELERATION_RAD_S2
        self._time_s = now_s

    @property
    def current_acceleration_rad_s2(self) -> float:
        """How fast its speed changes; 0 at the goal."""
        missing = self.goal_rad_s - self.speed_rad_s
        return math.copysign(self.acceleration_rad_s2, missing) if missing else 0.0

    @property
    def effort(self) -> float:
        """The fraction of its torque that accelerates the wheel, -1 to 1."""
        return max(-1.0, min(1.0, (self.goal_rad_s - self.speed_rad_s) / self.acceleration_rad_s2 / 0.1))

    def advance(self, now_s: float) -> None:
        """Move up to `now_s`. The result is exact for steps of any length, even on a busy machine."""
        step_s = max(0.0, now_s - self._time_s)
        self._time_s = max(self._time_s, now_s)
        missing = self.goal_rad_s - self.speed_rad_s
        ramp_s = min(step_s, abs(missing) / self.acceleration_rad_s2)
        reached = self.speed_rad_s + self.current_acceleration_rad_s2 * ramp_s
        if ramp_s < step_s:
            reached = self.goal_rad_s
        self.angle_rad += (self.speed_rad_s + reached) / 2 * ramp_s + reached * (step_s - ramp_s)
        self.speed_rad_s = reached
