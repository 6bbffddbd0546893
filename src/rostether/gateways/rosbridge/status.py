"""Statuses: a rosbridge server's reports of errors and losses, at the level that the client wants."""

from __future__ import annotations

import json
from enum import IntEnum

from rostether.errors import RemoteProtocolError
from rostether.gateways.client_json import show


class StatusLevel(IntEnum):
    """Levels of statuses, the most severe first. A client receives the statuses up to its level."""

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


# Losses are reported unless a client wants only errors; the default in the protocol is `error`.
DEFAULT_LEVEL = StatusLevel.WARNING


def status_message(level: StatusLevel, text: str, request_id: object = None) -> str:
    """Return a status message; `request_id` is the id of the request."""
    fields: dict[str, object] = {"op": "status", "level": level.name.lower(), "msg": text}
    if request_id is not None:
        fields["id"] = request_id
    return json.dumps(fields)
