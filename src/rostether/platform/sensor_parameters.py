"""The parameters that all sensor nodes have."""

from __future__ import annotations

import os
import re
import socket

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.graph.node_parameters import NodeParameters
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.registered_sensor import platform_word

# Faster sources would occupy the event loop.
MAX_RATE_HZ = 1000.0


class SensorKind(Struct, frozen=True):
    """A node's default sensor, before its parameters are read."""

    word: str
    sensor_type: str
    message_type: str
    rate_hz: float
    unit: str = ""


def default_platform() -> str:
    """Return the robot's name: PLATFORM_NAME, else the host name."""
    return os.environ.get("PLATFORM_NAME") or socket.gethostname()


async def read_description(parameters: NodeParameters, kind: SensorKind) -> SensorDescription:
    """Return a sensor's description with the parameters of its node. Raises ConfigError."""
    platform = await parameters.text(default_platform(), "platform_name")
    word = await parameters.text(kind.word, "id")
    if not re.fullmatch(r"[A-Za-z]\w*", word, re.ASCII):
        raise ConfigError(f"~id must be a word such as front, not {word!r:.100}")
    return SensorDescription(
        id=f"{platform_word(platform)}/{word}",
        platform=platform,
        sensor_type=kind.sensor_type,
        message_type=kind.message_type,
        name=await parameters.text(word, "name"),
        unit=await parameters.text(kind.unit, "unit"),
        frame_id=await parameters.text("", "frame_id"),
        rate_hz=await read_rate(parameters, kind.rate_hz),
    )


async def read_rate(parameters: NodeParameters, default_hz: float) -> float:
    """Return ~rate, in hertz. Raises ConfigError."""
    rate_hz = await parameters.number(default_hz, "rate")
    if not 0 < rate_hz <= MAX_RATE_HZ:
        raise ConfigError(f"~rate must be above 0 and at most {MAX_RATE_HZ:g} Hz, not {rate_hz:g} Hz")
    return rate_hz
