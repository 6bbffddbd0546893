"""Writes the sketch of a sensor: a library example with the user's pins and topic."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.mechanisms.text import write_failure
from rostether.names.graph_name import validate_name

_PIN = re.compile(r"(A?)([0-9]{1,2})")
_SKETCH_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")


class SensorKind(Struct, frozen=True):
    """A kind of sensor: the example, its pins by the names of their constants, and its topic."""

    example: str
    summary: str
    pins: Mapping[str, str]
    topic: str


KINDS = {
    "ultrasound": SensorKind("Ultrasound", "distance, HC-SR04", {"TRIG": "6", "ECHO": "5"}, "ultrasound"),
    "infrared": SensorKind("IrRanger", "distance, Sharp GP2Y0A41SK0F", {"SENSOR": "A0"}, "range_data"),
    "temperature": SensorKind("Temperature", "degrees Celsius, TMP36", {"SENSOR": "A0"}, "temperature"),
    "button": SensorKind("button_example", "a push button", {"BUTTON": "7"}, "pushed"),
}


def write_sketch(folder: Path, kind: SensorKind, examples: Path, pins: Mapping[str, str], topic: str) -> Path:
    """Write FOLDER/FOLDER.ino and return it; `pins` replace those of the kind, by name.

    Raises InvalidNameError for an invalid topic, ConfigError for an invalid name or pin, or if the file
    exists.
    """
    if not _SKETCH_NAME.fullmatch(folder.name):
        raise ConfigError(f"{folder.name!r} cannot be a sketch's name; use letters, digits and _")
    validate_name(topic)
    chosen = {**kind.pins, **pins}
    for name, pin in chosen.items():
        if name not in kind.pins:
            raise ConfigError(f"there is no pin {name!r}; this sensor has {', '.join(kind.pins)}")
        if not _PIN.fullmatch(pin):
            raise ConfigError(f"{name}={pin}: write a pin as a number, or as A0 for an analog one")
        if kind.pins[name].startswith("A") and not pin.startswith("A"):
            raise ConfigError(f"{name}={pin}: this sensor needs an analog pin, such as A0")
    if len(set(chosen.values())) < len(chosen):
        raise ConfigError("two connections of the sensor need two different pins")
    text = (examples / kind.example / f"{kind.example}.ino").read_text(encoding="utf-8")
    file = folder / f"{folder.name}.ino"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with file.open("x", encoding="utf-8") as stream:
            stream.write(_adapted(text, kind, chosen, folder.name, topic))
    except FileExistsError:
        raise ConfigError(f"{file} exists; choose another name or folder") from None
    except OSError as error:
        raise ConfigError(write_failure(file, error)) from None
    return file


def _adapted(text: str, kind: SensorKind, pins: Mapping[str, str], name: str, topic: str) -> str:
    changed = {old: pins[each] for each, old in kind.pins.items()}
    comments: list[str] = []
    code: list[str] = []
    for line in text.splitlines(keepends=True):
        (code if code or not line.startswith("//") else comments).append(line)
    head = "".join(comments).replace(f"// {kind.example}:", f"// {name}:")
    head = re.sub(r"(?<=\bpin )[0-9]+\b|\bA[0-9]+\b", lambda found: changed.get(found[0], found[0]), head)
    head = head.replace(f'"{kind.topic}"', f'"{topic}"').replace(f"/{kind.topic}", f"/{topic.lstrip('/')}")
    body = "".join(code).replace(f'("{kind.topic}", &', f'("{topic}", &')
    for each, pin in pins.items():
        body = re.sub(rf"^const int {each} = \w+;", f"const int {each} = {pin};", body, flags=re.MULTILINE)
    return head + body
