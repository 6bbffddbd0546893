"""Decodes a joystick's events from /dev/input/js* on Linux into axes and buttons.

    time_ms uint32 | value int16 | type uint8 (1 button, 2 axis, + 0x80 at opening) | number uint8

Source: linux/joystick.h; the content of a Joy message is the same as from joy_node.
"""

from __future__ import annotations

import struct
from enum import Enum

import msgspec
from msgspec import field

EVENT = struct.Struct("<IhBB")
_BUTTON, _AXIS, _INITIAL = 0x01, 0x02, 0x80
_FULL = 32767.0
# A larger dead zone would leave almost nothing of an axis.
MAX_DEADZONE = 0.9


class PublishTiming(Enum):
    """When to publish after an event: never, after the coalesce interval, or immediately."""

    NEVER = 0
    SOON = 1
    NOW = 2


class Joystick(msgspec.Struct):
    """The state after all events; `deadzone` is the fraction of an axis around its center that counts as 0.

    With `sticky_buttons`, a press turns a button on, and the next press turns it off. With
    `default_trig_val`, an axis has its real value from the opening on; otherwise it is 0 until it moves.
    """

    deadzone: float = 0.05
    sticky_buttons: bool = False
    default_trig_val: bool = False
    axes: list[float] = field(default_factory=list)
    buttons: list[int] = field(default_factory=list)
    _pressed: list[bool] = field(default_factory=list)
    _released_axes: list[float] = field(default_factory=list)
    _rest: bytes = b""

    def __post_init__(self) -> None:
        # Older launch files use the device's units.
        deadzone = self.deadzone / _FULL if self.deadzone >= 1 else self.deadzone
        self.deadzone = min(max(deadzone, 0.0), MAX_DEADZONE)

    def feed(self, data: bytes) -> PublishTiming:
        """Handle bytes of the device, which may contain partial events; return when to publish."""
        data = self._rest + data
        end = len(data) - len(data) % EVENT.size
        self._rest = data[end:]
        timing = PublishTiming.NEVER
        for _, value, kind, number in EVENT.iter_unpack(data[:end]):
            timing = max(timing, self._apply_event(value, kind, number), key=lambda each: each.value)
        return timing

    def release(self) -> None:
        """Move all axes to their resting positions, and release all buttons."""
        self.axes = list(self._released_axes)
        self.buttons = [0] * len(self.buttons)

    def _apply_event(self, value: int, kind: int, number: int) -> PublishTiming:
        is_initial = bool(kind & _INITIAL)
        if kind & ~_INITIAL == _BUTTON:
            self._press(number, is_pressed=value != 0)
            return PublishTiming.SOON if is_initial else PublishTiming.NOW
        if kind & ~_INITIAL == _AXIS:
            missing = number + 1 - len(self.axes)
            self.axes += [0.0] * missing
            self._released_axes += [0.0] * missing
            if self.default_trig_val or not is_initial:
                self.axes[number] = self._scaled(value)
            if self.default_trig_val and is_initial:
                self._released_axes[number] = self.axes[number]
            return PublishTiming.SOON
        return PublishTiming.NEVER

    def _press(self, number: int, *, is_pressed: bool) -> None:
        missing = number + 1 - len(self.buttons)
        self.buttons += [0] * missing
        self._pressed += [False] * missing
        if not self.sticky_buttons:
            self.buttons[number] = int(is_pressed)
        elif is_pressed and not self._pressed[number]:
            self.buttons[number] = 1 - self.buttons[number]
        self._pressed[number] = is_pressed

    def _scaled(self, value: int) -> float:
        # In ROS, left and forward are positive; in the device, right and backward.
        unused = _FULL * self.deadzone
        if abs(value) <= unused:
            return 0.0
        moved = value - unused if value > 0 else value + unused
        return -moved / (1 - self.deadzone) / _FULL
