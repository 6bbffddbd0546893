"""Converts the texts of attributes to values, like roslaunch."""

from __future__ import annotations

import shlex
from typing import Any

from rostether.errors import LaunchError
from rostether.param_yaml import leaves, parse_value

TYPES = ("auto", "str", "string", "int", "double", "bool", "boolean", "yaml")


def convert(text: str, type_name: str) -> Any:
    """Return a text converted to a type (one of TYPES). Raises LaunchError, ConfigError."""
    match type_name:
        case "auto":
            return _guess(text)
        case "str" | "string":
            return text
        case "int":
            return _number(text, int, "a whole number")
        case "double":
            return _number(text, float, "a number")
        case "bool" | "boolean":
            return as_bool(text)
        case "yaml":
            return parse_value(text, "value") if text else None
    raise LaunchError(f"type={type_name!r:.200} is unknown; known: {', '.join(TYPES)}")


def as_bool(text: str) -> bool:
    """Return the value of if=, unless= or a parameter of type bool. Raises LaunchError."""
    word = text.lower().strip()
    if word in ("true", "1"):
        return True
    if word in ("false", "0"):
        return False
    raise LaunchError(f"{text!r:.200} is not true or false; write one of them")


def split_words(command: str) -> list[str]:
    """Return the words of a command, split as a shell splits them. Raises LaunchError."""
    try:
        return shlex.split(command)
    except ValueError as error:
        raise LaunchError(f"{command!r}: {str(error).lower()}; correct its quotes") from None


def check_value(name: str, value: Any) -> None:
    """Raise ConfigError for a value that no parameter can have, such as null."""
    for _ in leaves(name, value):
        pass


def _guess(text: str) -> Any:
    try:
        if "." in text:
            return float(text)
        # Python reads 1_000 as a number, ROS reads it as a string.
        if "_" not in text:
            return int(text)
    except ValueError:
        pass
    word = text.lower()
    return word == "true" if word in ("true", "false") else text


def _number(text: str, kind: type[int] | type[float], what: str) -> int | float:
    try:
        return kind(text)
    except ValueError:
        raise LaunchError(f"{text!r:.200} is not {what}; correct it, or choose another type=") from None
