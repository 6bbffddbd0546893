"""The node arduino_control: a joystick's axes on `joy` published as commands on `arduino_control`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from rostether.errors import ConfigError
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.stick import DEFAULT_DEADZONE, FORMULAS

# The reference node uses this queue length.
_QUEUE_MESSAGES = 10


@dataclass(frozen=True, slots=True)
class StickSettings:
    """The parameters of arduino_control."""

    deadzone: float = DEFAULT_DEADZONE
    formula: str = "reference"


async def publish_commands(
    graph: TypedGraph, settings: StickSettings, report: Callable[[Level, str], None]
) -> None:
    """Publish one command for each message of the joystick. Raises ConfigError, GraphError."""
    formula = FORMULAS.get(settings.formula)
    if formula is None:
        raise ConfigError(f"~formula is {' or '.join(FORMULAS)}, not {settings.formula!r:.200}")
    if not math.isfinite(settings.deadzone):
        raise ConfigError(f"~deadzone must be a finite number, not {settings.deadzone}")
    deadzone = abs(settings.deadzone)
    publisher = await graph.publisher("arduino_control", "arduino_control/ArduinoControl")
    reported = False
    async for message in graph.messages("joy", "sensor_msgs/Joy", queue_size=_QUEUE_MESSAGES):
        axes = message.axes
        fault = _fault(axes)
        if fault and not reported:
            report(Level.WARN, f"{fault} on {graph.resolve('joy')}; commands with speed 0 are sent meanwhile")
        reported = bool(fault)
        command = formula(0.0, 0.0, deadzone) if fault else formula(axes[0], axes[1], deadzone)
        publisher.publish(dir=command.direction_deg, speed=command.speed)


def _fault(axes: list[float]) -> str:
    if len(axes) < 2:
        return f"the joystick has {len(axes)} of the two axes that driving needs"
    return "" if math.isfinite(axes[0]) and math.isfinite(axes[1]) else "an axis is not a finite number"
