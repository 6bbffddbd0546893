"""Formats values from clients for error texts."""

from __future__ import annotations

import json
from itertools import islice

from rostether.mechanisms.text import escape_line

# A longer value would hide the rest of the error.
_MAX_SHOWN = 80
_SHOWN_DEPTH = 3
_REST = "..."


def show(value: object) -> str:
    """Return a client's value for an error: its JSON, shortened to one line."""
    # Millions of values would take a second, in which no other client is served.
    text = json.dumps(_beginning(value, _SHOWN_DEPTH), ensure_ascii=False)
    return escape_line(text.replace(f'"{_REST}"', _REST), _MAX_SHOWN)


def _beginning(value: object, depth: int) -> object:
    if isinstance(value, bytes):
        return value[: _MAX_SHOWN + 1].decode("utf-8", "replace")
    if isinstance(value, str):
        return value[: _MAX_SHOWN + 1]
    if isinstance(value, list):
        # A value takes at least two characters.
        return [_beginning(each, depth - 1) for each in value[:_MAX_SHOWN]] if depth else [_REST]
    if isinstance(value, dict):
        if not depth:
            return {_REST: _REST}
        items = islice(value.items(), _MAX_SHOWN)
        return {name[:_MAX_SHOWN]: _beginning(each, depth - 1) for name, each in items}
    return value
