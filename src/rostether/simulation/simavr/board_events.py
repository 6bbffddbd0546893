"""The events of a simulated board."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from msgspec import Struct

from rostether.errors import BoardError


class BoardEvent(Struct, frozen=True):
    """One event: `name` as in the reference of commands and events, `time_s` in the board's time."""

    name: str
    time_s: float
    values: Mapping[str, Any] = MappingProxyType({})

    def __getitem__(self, key: str) -> Any:
        """Return one of the event's values. Raises KeyError."""
        return self.values[key]


def parse_event(line: bytes) -> BoardEvent:
    """Read a line of the runner. Raises BoardError if it is not an event."""
    try:
        values = json.loads(line)
        name, time_us = values.pop("event"), values.pop("time_us")
        return BoardEvent(str(name), float(time_us) / 1e6, MappingProxyType(values))
    except (ValueError, KeyError, AttributeError, TypeError) as error:
        raise BoardError(f"the simulated board's runner printed an unknown line: {line[:80]!r}") from error


# Explanations of the problems whose names and values do not explain them.
_MEANINGS = {
    "behind": "this computer was too busy to simulate the board in real time",
    "overrun": "the program disabled interrupts for too long, and received bytes were lost",
    "lost_serial": "no program read these bytes in time",
    "lost_events": "these events were not read in time",
    "stack_low": "the stack came close to the variables: the program needs more RAM than is safe",
    "stack_overflow": "the stack overwrote variables: the program needs more RAM than the board has",
}


def show_event(event: BoardEvent) -> str:
    """Format an event in one line: the board's time in seconds, the event, its values, the meaning."""
    values = dict(event.values)
    text = values.pop("text", "") or _MEANINGS.get(event.name, "")
    if event.name == "serial":
        data = bytes.fromhex(values["data"])
        if is_text(data):
            values["data"] = json.dumps(data.decode("ascii"))
    pin = values.pop("pin", None)
    parts = [event.name.replace("_", " "), *([str(pin)] if pin is not None else [])]
    parts += [f"{key}={_show(value)}" for key, value in values.items() if value != ""]
    line = f"{event.time_s:12.6f}  {' '.join(parts)}"
    return f"{line}: {text}" if text else line


def is_text(data: bytes) -> bool:
    """Return whether a sketch printed these bytes as ASCII text."""
    return data.isascii() and "".join(data.decode("ascii").split()).isprintable()


def _show(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
