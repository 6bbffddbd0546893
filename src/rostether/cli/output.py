"""Writing results: lines for people, and one JSON object a line for scripts."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping
from typing import Any

import click

from rostether.rostime import Duration, Time

json_option: Callable[[Any], Any] = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object a line."
)


def write_line(text: str = "") -> None:
    """Write a line to stdout and flush it: a pipe's reader wants it now."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def warn(text: str) -> None:
    """Write a line to stderr."""
    sys.stdout.flush()
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def write_json(value: object) -> None:
    """Write one object as one line of JSON; see `to_json`."""
    write_line(json.dumps(to_json(value), ensure_ascii=False, allow_nan=False))


def to_json(value: object) -> object:
    """Return a value as JSON knows it.

    Messages become objects, times `{"secs", "nsecs"}`, bytes a list of numbers; what is no finite number
    becomes null, because JSON has no NaN.
    """
    if isinstance(value, Time | Duration):
        return {"secs": value.secs, "nsecs": value.nsecs}
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, str):
        # JSON is text: bytes that were no UTF-8 cannot be kept.
        return value.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, bytes | bytearray | memoryview):
        return list(value)
    if isinstance(value, Mapping):
        return {str(key): to_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_json(item) for item in value]
    slots: tuple[str, ...] = getattr(type(value), "__slots__", ())
    return {name: to_json(getattr(value, name)) for name in slots}
