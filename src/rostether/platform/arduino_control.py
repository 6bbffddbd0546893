"""The node arduino_control: a joystick's axes on `joy` published as commands on `arduino_control`."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import TypeAlias

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.graph.ports import Level, Report
from rostether.graph.typed_graph import TypedGraph

# The reference node uses this queue length.
_QUEUE_MESSAGES = 10

DEFAULT_DEADZONE = 0.1


class StickSettings(Struct, frozen=True):
    """The parameters of arduino_control."""

    deadzone: float = DEFAULT_DEADZONE
    formula: str = "reference"


async def publish_commands(graph: TypedGraph, settings: StickSettings, report: Report) -> None:
    """Publish one command for each message of the joystick. Raises ConfigError, GraphError."""
    formula = FORMULAS.get(settings.formula)
    if formula is None:
        raise ConfigError(f"~formula must be {' or '.join(FORMULAS)}, not {settings.formula!r:.200}")
    if not math.isfinite(settings.deadzone):
        raise ConfigError(f"~deadzone must be a finite number, not {settings.deadzone}")
    deadzone = abs(settings.deadzone)
    publisher = await graph.publisher("arduino_control", "arduino_control/ArduinoControl")
    is_reported = False
    async for message in graph.messages("joy", "sensor_msgs/Joy", queue_size=_QUEUE_MESSAGES):
        axes = message.axes
        fault = _fault(axes)
        if fault and not is_reported:
            report(Level.WARN, f"{fault} on {graph.resolve('joy')}; commands with speed 0 are sent meanwhile")
        is_reported = bool(fault)
        command = formula(0.0, 0.0, deadzone) if fault else formula(axes[0], axes[1], deadzone)
        publisher.publish(dir=command.direction_deg, speed=command.speed)


def _fault(axes: list[float]) -> str:
    if len(axes) < 2:
        return f"the joystick has {len(axes)} of the two axes that driving needs"
    return "" if math.isfinite(axes[0]) and math.isfinite(axes[1]) else "an axis is not a finite number"


class DriveCommand(Struct, frozen=True):
    """A direction in degrees and a speed; 1.0 is full speed."""

    direction_deg: float
    speed: float


Formula: TypeAlias = Callable[[float, float, float], DriveCommand]


def reference_command(left: float, forward: float, deadzone: float) -> DriveCommand:
    """Return the command that the reference node sends.

    The speed is 0 only if both axes are below the dead zone, and 1.414 in the corners. The angle is rounded
    to 32 bits, because the reference node uses 32-bit axes.
    """
    angle = _float32(_float32(math.atan2(-left, forward)) * 180)
    is_still = abs(left) < deadzone and abs(forward) < deadzone
    # The reference node's value of pi.
    return DriveCommand(angle / 3.14159265359, 0.0 if is_still else math.sqrt(forward**2 + left**2))


def radial_command(left: float, forward: float, deadzone: float) -> DriveCommand:
    """Return a command whose speed grows from 0 at the edge of a round dead zone to 1, in every direction."""
    distance = math.hypot(left, forward)
    if distance <= deadzone or deadzone >= 1:
        return DriveCommand(0.0, 0.0)
    speed = (min(distance, 1.0) - deadzone) / (1 - deadzone)
    return DriveCommand(math.degrees(math.atan2(-left, forward)), speed)


FORMULAS: dict[str, Formula] = {"reference": reference_command, "radial": radial_command}


def _float32(value: float) -> float:
    number: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return number
