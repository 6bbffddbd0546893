"""robot.toml: all programs of one machine of a robot, in one file."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from msgspec import Struct, field

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure
from rostether.mechanisms.toml_text import parse_toml, read_toml_text

# More programs than a robot's computer runs; each is a process.
MAX_PARTS = 64
# Each line of a part's output begins with its name.
MAX_NAME_CHARACTERS = 64
_VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_TOP = {"name", "master", "address", "interface", "environment", "parts"}
# The network interface of a robot, for its parts that send to groups.
INTERFACE_VARIABLE = "ROSTETHER_INTERFACE"
_VARIABLES = {
    "PLATFORM_NAME": "name",
    "ROS_MASTER_URI": "master",
    "ROS_IP": "address",
    INTERFACE_VARIABLE: "interface",
}


class Part(Struct, frozen=True):
    """One program of a robot: a name, and the arguments of `rostether`."""

    name: str
    words: tuple[str, ...]


class RobotFile(Struct, frozen=True):
    """The content of a robot.toml."""

    name: str = ""
    environment: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[Part, ...] = ()


def read_robot_text(path: Path) -> str:
    """Return the text of a robot.toml. Raises ConfigError."""
    try:
        return read_toml_text(path)
    except FileNotFoundError as error:
        raise ConfigError(read_failure(path, error)) from None


def parse_robot_file(text: str, file: str, commands: Collection[str]) -> RobotFile:
    """Return the content of a robot.toml; `file` is its name in errors. Raises ConfigError.

    Each part's first argument must be in `commands`.
    """
    content = parse_toml(text, file)
    try:
        return _robot(content, commands)
    except ConfigError as error:
        raise ConfigError(f"{file}: {error}") from None


def check_interface(name: str) -> None:
    """Raise ConfigError for a text that cannot be the name of a network interface."""
    # Linux allows 15 bytes.
    is_name = re.fullmatch(r"[^\s/,]+", name) is not None and len(os.fsencode(name)) <= 15
    if not is_name or re.fullmatch(r"[\d.]+", name):
        raise ConfigError(f"interface: {name!r:.80} is not the name of a network interface, such as wlan0")


def _robot(content: Mapping[str, Any], commands: Collection[str]) -> RobotFile:
    unknown = sorted(content.keys() - _TOP)
    if unknown:
        raise ConfigError(f"unknown key {unknown[0]!r}; known keys: {', '.join(sorted(_TOP))}")
    environment = {
        _checked_variable(name): _text(f"environment.{name}", value)
        for name, value in _table("environment", content.get("environment", {})).items()
    }
    name = _text("name", content.get("name", ""))
    for variable, key in _VARIABLES.items():
        if key in content:
            environment[variable] = _text(key, content[key])
    if interface := environment.get(INTERFACE_VARIABLE):
        check_interface(interface)
    parts = tuple(
        _part(each, words, commands) for each, words in _table("parts", content.get("parts", {})).items()
    )
    if not parts:
        raise ConfigError('no parts; add a table [parts] with a line such as boards = "serve"')
    if len(parts) > MAX_PARTS:
        raise ConfigError(f"at most {MAX_PARTS} parts are allowed, not {len(parts)}")
    return RobotFile(name, environment, parts)


def _checked_variable(name: str) -> str:
    if not _VARIABLE.fullmatch(name):
        raise ConfigError(f"environment: {name!r:.80} is not the name of a variable, such as ROS_LOG_DIR")
    return name


def _part(name: str, words: Any, commands: Collection[str]) -> Part:
    if not name or len(name) > MAX_NAME_CHARACTERS or not name.isprintable():
        raise ConfigError(
            f"parts: a name has 1 to {MAX_NAME_CHARACTERS} printable characters, not {name!r:.80}"
        )
    try:
        split = shlex.split(_text(f"parts.{name}", words))
    except ValueError as error:
        raise ConfigError(f"parts.{name} must be a command line: {error}") from None
    if split[:1] == ["rostether"]:
        split = split[1:]
    if not split or split[0] not in commands:
        raise ConfigError(f'parts.{name} must be a rostether command, such as "serve /dev/ttyACM0"')
    return Part(name, tuple(split))


def _text(key: str, value: Any) -> str:
    if not isinstance(value, str) or "\n" in value or "\0" in value:
        raise ConfigError(f"{key} must be one line of text in quotes")
    return value


def _table(key: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise ConfigError(f"{key} must be a table: [{key}]")
    return value
