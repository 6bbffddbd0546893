"""The parameters of the platform's nodes: private ones, and the names that its first nodes read."""

from __future__ import annotations

import os
import re
import socket
from dataclasses import dataclass

from rostether.errors import ConfigError
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensors.registered_sensor import SensorDescription, platform_word

MAX_RATE_HZ = 1000.0


class Parameters:
    """Reads `~name`, else `NODE/name` in the node's namespace, where the platform's first nodes look."""

    def __init__(self, graph: TypedGraph, node: str) -> None:
        self._graph = graph
        self._node = node

    async def value(self, default: ParamValue, *names: str) -> ParamValue:
        """Return the first set parameter among several spellings of its name."""
        for name in names:
            for full_name in (f"~{name}", f"{self._node}/{name}"):
                if await self._graph.raw.has_param(full_name):
                    return await self._graph.raw.get_param(full_name)
        return default

    async def text(self, default: str, *names: str) -> str:
        """Return the value as text."""
        return str(await self.value(default, *names))

    async def flag(self, default: bool, *names: str) -> bool:
        """Return true or false. Raises ConfigError."""
        value = await self.value(default, *names)
        if not isinstance(value, bool):
            raise ConfigError(f"~{names[0]} must be true or false, not {value!r:.200}")
        return value

    async def number(self, default: float, *names: str) -> float:
        """Return a number. Raises ConfigError."""
        value = await self.value(default, *names)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigError(f"~{names[0]} must be a number, not {value!r:.200}")
        return float(value)

    async def whole(self, default: int, least: int, most: int, *names: str) -> int:
        """Return a whole number within limits. Raises ConfigError."""
        value = await self.value(default, *names)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise ConfigError(f"~{names[0]} is a whole number from {least} to {most}, not {value!r:.200}")
        return value

    async def words(self, *names: str) -> tuple[str, ...]:
        """Return a list of texts, which may be one text with commas."""
        value = await self.value("", *names)
        texts = [str(each) for each in value] if isinstance(value, list) else str(value).split(",")
        return tuple(stripped for each in texts if (stripped := each.strip()))


@dataclass(frozen=True, slots=True)
class SensorKind:
    """A node's default sensor, before its parameters are read."""

    word: str
    sensor_type: str
    message_type: str
    rate_hz: float
    unit: str = ""


def default_platform() -> str:
    """Return the robot's name: PLATFORM_NAME, else this machine's."""
    return os.environ.get("PLATFORM_NAME") or socket.gethostname()


async def read_description(parameters: Parameters, kind: SensorKind) -> SensorDescription:
    """Return a sensor's description with the parameters of its node. Raises ConfigError."""
    platform = await parameters.text(default_platform(), "platform_name")
    word = await parameters.text(kind.word, "id")
    if not re.fullmatch(r"[A-Za-z]\w*", word, re.ASCII):
        raise ConfigError(f"~id is a word such as front, not {word!r:.100}")
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


async def read_rate(parameters: Parameters, default_hz: float) -> float:
    """Return ~rate. Raises ConfigError."""
    rate_hz = await parameters.number(default_hz, "rate")
    if not 0 < rate_hz <= MAX_RATE_HZ:
        raise ConfigError(f"~rate is above 0 and at most {MAX_RATE_HZ:g}, not {rate_hz:g}")
    return rate_hz
