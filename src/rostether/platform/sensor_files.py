"""The files of the sensing manager: sensors.toml, written by users, and its saved state."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec

from rostether.errors import ConfigError, InvalidNameError
from rostether.mechanisms.state_file import load_state, store_state
from rostether.mechanisms.toml_text import parse_toml, read_toml_text
from rostether.names.graph_name import validate_name
from rostether.platform.sensor_registration import MAX_TEXT_CHARACTERS
from rostether.platform.sensor_registry import MAX_SENSORS, MESSAGE_TYPES, Sensor

# The saved state of a thousand sensors is about 400 KB, and 12 MB with the longest texts, whose characters
# need up to 12 bytes each. With a lower limit, a restart could forget all sensors.
_MAX_STATE_BYTES = 16 << 20

_REGISTERED_TOPIC = re.compile(r"/sensor_node\d+")
_KEYS = ("name", "platform", "type", "unit")


def read_sensors_toml(path: Path) -> list[Sensor]:
    """Return the sensors in a file, which has one line for each topic. Raises ConfigError.

    "/arm/ultrasound" = { name = "Distance", unit = "m" }
    """
    content = parse_toml(read_toml_text(path), str(path))
    if len(content) > MAX_SENSORS:
        raise ConfigError(f"{path}: at most {MAX_SENSORS} sensors are allowed, not {len(content)}")
    return [_sensor(path, topic, entry) for topic, entry in content.items()]


def _sensor(path: Path, topic: str, entry: Any) -> Sensor:
    try:
        validate_name(topic)
    except InvalidNameError as error:
        raise ConfigError(f"{path}: {error}") from None
    if not topic.startswith("/"):
        raise ConfigError(f'{path}: write the topic "{topic}" with a slash before it')
    if _REGISTERED_TOPIC.fullmatch(topic):
        raise ConfigError(
            f"{path}: {topic} belongs to a registered sensor; name it with `rostether sensor rename`"
        )
    if not isinstance(entry, dict):
        raise ConfigError(f'{path}: write "{topic}" = {{ name = "Distance", unit = "m" }}')
    for key, value in entry.items():
        if key not in _KEYS:
            raise ConfigError(f"{path}: {topic} has an unknown key {key!r:.100}; known: {', '.join(_KEYS)}")
        if not isinstance(value, str) or not value.isprintable() or len(value) > MAX_TEXT_CHARACTERS:
            raise ConfigError(
                f"{path}: {key} of {topic} must be text of up to {MAX_TEXT_CHARACTERS} characters"
            )
    sensor_type = entry.get("type", "ANALOG")
    if sensor_type not in MESSAGE_TYPES:
        raise ConfigError(
            f"{path}: type of {topic} must be one of {', '.join(MESSAGE_TYPES)}, not {sensor_type!r}"
        )
    first, _, rest = topic[1:].partition("/")
    platform = entry.get("platform") or (first if rest else os.environ.get("PLATFORM_NAME", "")) or "Platform"
    name = entry.get("name") or topic
    return Sensor(topic[1:], -1, platform, sensor_type, topic, name, unit=entry.get("unit", ""))


def read_state(path: Path) -> list[Sensor]:
    """Return the sensors of an earlier run; none if the file is missing or damaged."""
    entries = load_state(path, _MAX_STATE_BYTES).get("sensors")
    if not isinstance(entries, list):
        return []
    restored = map(_restored, entries[:MAX_SENSORS])
    return [each for each in restored if each is not None]


def write_state(path: Path, sensors: Iterable[Sensor]) -> None:
    """Write the sensors; a power cut leaves the old or the new file. Raises OSError."""
    store_state(path, {"sensors": [msgspec.structs.asdict(each) for each in sensors]}, is_durable=True)


def _restored(entry: object) -> Sensor | None:
    with suppress(msgspec.ValidationError):
        return msgspec.convert(entry, Sensor)
    return None
