"""The control table of a DYNAMIXEL XL430-W250: its registers, their limits and factory values.

Source: ROBOTIS e-Manual, XL430-W250. The registers of position and PWM control have no effect, because wheels
do not need them.
"""

from __future__ import annotations

from msgspec import Struct

MODEL = 1060
FIRMWARE = 45
# RAM begins here; registers before it keep their values without power, and are locked while the torque is on.
RAM_START = 64


class Register(Struct, frozen=True):
    """One number in the table; `size` is in bytes. `lowest` and `highest` limit the values to write."""

    name: str
    address: int
    size: int
    initial: int = 0
    is_writable: bool = False
    lowest: int = 0
    highest: int = 0

    @property
    def is_signed(self) -> bool:
        """Whether negative values exist."""
        return self.lowest < 0


def _rw(name: str, address: int, size: int, initial: int, lowest: int, highest: int) -> Register:
    return Register(name, address, size, initial, is_writable=True, lowest=lowest, highest=highest)


def _signed(name: str, address: int, size: int) -> Register:
    return Register(name, address, size, lowest=-1)


REGISTERS = (
    Register("model_number", 0, 2, MODEL),
    Register("model_information", 2, 4),
    Register("firmware_version", 6, 1, FIRMWARE),
    _rw("id", 7, 1, 1, 0, 252),
    _rw("baud_rate", 8, 1, 3, 0, 7),
    _rw("return_delay_time", 9, 1, 250, 0, 254),
    _rw("drive_mode", 10, 1, 0, 0, 5),
    _rw("operating_mode", 11, 1, 3, 0, 16),
    _rw("secondary_id", 12, 1, 255, 0, 255),
    _rw("protocol_type", 13, 1, 2, 1, 2),
    _rw("homing_offset", 20, 4, 0, -1044479, 1044479),
    _rw("moving_threshold", 24, 4, 10, 0, 1023),
    _rw("temperature_limit", 31, 1, 72, 0, 100),
    _rw("max_voltage_limit", 32, 2, 140, 60, 140),
    _rw("min_voltage_limit", 34, 2, 60, 60, 140),
    _rw("pwm_limit", 36, 2, 885, 0, 885),
    _rw("velocity_limit", 44, 4, 265, 0, 1023),
    _rw("max_position_limit", 48, 4, 4095, 0, 4095),
    _rw("min_position_limit", 52, 4, 0, 0, 4095),
    _rw("shutdown", 63, 1, 0x34, 0, 0x3F),
    _rw("torque_enable", 64, 1, 0, 0, 1),
    _rw("led", 65, 1, 0, 0, 1),
    _rw("status_return_level", 68, 1, 2, 0, 2),
    Register("registered_instruction", 69, 1),
    Register("hardware_error_status", 70, 1),
    _rw("velocity_i_gain", 76, 2, 1000, 0, 16383),
    _rw("velocity_p_gain", 78, 2, 100, 0, 16383),
    _rw("bus_watchdog", 98, 1, 0, -1, 127),
    _rw("goal_pwm", 100, 2, 885, -885, 885),
    # Its limit is the register `velocity_limit`.
    _rw("goal_velocity", 104, 4, 0, -1023, 1023),
    _rw("profile_acceleration", 108, 4, 0, 0, 32767),
    _rw("profile_velocity", 112, 4, 0, 0, 32767),
    _rw("goal_position", 116, 4, 0, -1048575, 1048575),
    Register("realtime_tick", 120, 2),
    Register("moving", 122, 1),
    Register("moving_status", 123, 1),
    _signed("present_pwm", 124, 2),
    _signed("present_load", 126, 2),
    _signed("present_velocity", 128, 4),
    _signed("present_position", 132, 4),
    _signed("velocity_trajectory", 136, 4),
    _signed("position_trajectory", 140, 4),
    Register("present_input_voltage", 144, 2, 120),
    Register("present_temperature", 146, 1, 35),
)
BY_NAME = {register.name: register for register in REGISTERS}
TABLE_BYTES = 147
