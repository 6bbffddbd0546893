"""Statuses: what a rosbridge server tells its client of mistakes and losses, as loud as the client wants."""

from __future__ import annotations

import json
from enum import IntEnum
from itertools import islice

from rostether.errors import RemoteProtocolError


class StatusLevel(IntEnum):
    """Levels of statuses, the worst lowest: a client gets those up to the one that it has set."""

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
            raise RemoteProtocolError(f"level wants one of {names}, got {show(text)}") from None


DEFAULT_LEVEL = StatusLevel.WARNING
"""Losses are reported unless a client wants only errors; the protocol's text says `error`."""

_MAX_SHOWN = 80
_SHOWN_DEPTH = 3


def status_message(level: StatusLevel, text: str, request_id: object = None) -> str:
    """Return a status as it is sent; `request_id` is the id of the message that it answers."""
    fields: dict[str, object] = {"op": "status", "level": level.name.lower(), "msg": text}
    if request_id is not None:
        fields["id"] = request_id
    return json.dumps(fields)


def show(value: object) -> str:
    """Return what a client sent as an error repeats it: short, on one line."""
    # The repr of millions of values would take a second, in which no other client is served.
    text = repr(_beginning(value, _SHOWN_DEPTH)).replace("Ellipsis", "...")
    return text if len(text) <= _MAX_SHOWN else f"{text[: _MAX_SHOWN - 3]}..."


def _beginning(value: object, depth: int) -> object:
    if isinstance(value, str | bytes):
        return value[: _MAX_SHOWN + 1]
    if isinstance(value, list):
        # A value takes two characters at least.
        return [_beginning(each, depth - 1) for each in value[:_MAX_SHOWN]] if depth else [...]
    if isinstance(value, dict):
        items = islice(value.items(), _MAX_SHOWN)
        return (
            {str(name)[:_MAX_SHOWN]: _beginning(each, depth - 1) for name, each in items} if depth else {...}
        )
    return value
