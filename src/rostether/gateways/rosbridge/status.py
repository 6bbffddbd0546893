"""Statuses: a rosbridge server's reports of mistakes and losses, at the level that the client wants."""

from __future__ import annotations

import json
from enum import IntEnum
from itertools import islice

from rostether.errors import RemoteProtocolError


class StatusLevel(IntEnum):
    """Levels of statuses; the worst level is the lowest, and a client receives those up to its level."""

    NONE = 0
    ERROR = 1
    WARNING = 2
    INFO = 3

    @classmethod
    def read(cls, text: object) -> StatusLevel:
        """Return the level of a name. Raises RemoteProtocolError."""
        try:
            return cls[text.upper()] if isinstance(text, str) else cls[""]
        except KeyError:
            names = ", ".join(each.name.lower() for each in cls)
            raise RemoteProtocolError(f"level must be one of {names}, got {show(text)}") from None


# Losses are reported unless a client wants only errors; the protocol's text says `error`.
DEFAULT_LEVEL = StatusLevel.WARNING

_MAX_SHOWN = 80
_SHOWN_DEPTH = 3


def status_message(level: StatusLevel, text: str, request_id: object = None) -> str:
    """Return a status message; `request_id` is the id of the request."""
    fields: dict[str, object] = {"op": "status", "level": level.name.lower(), "msg": text}
    if request_id is not None:
        fields["id"] = request_id
    return json.dumps(fields)


def show(value: object) -> str:
    """Return a client's value for an error: short, on one line."""
    # The repr of millions of values would take a second, in which no other client is served.
    text = repr(_beginning(value, _SHOWN_DEPTH)).replace("Ellipsis", "...")
    return text if len(text) <= _MAX_SHOWN else f"{text[: _MAX_SHOWN - 3]}..."


def _beginning(value: object, depth: int) -> object:
    if isinstance(value, str | bytes):
        return value[: _MAX_SHOWN + 1]
    if isinstance(value, list):
        # A value takes at least two characters.
        return [_beginning(each, depth - 1) for each in value[:_MAX_SHOWN]] if depth else [...]
    if isinstance(value, dict):
        items = islice(value.items(), _MAX_SHOWN)
        return (
            {str(name)[:_MAX_SHOWN]: _beginning(each, depth - 1) for name, each in items} if depth else {...}
        )
    return value
