"""Formats values from clients for error texts."""

from __future__ import annotations

from itertools import islice

_MAX_SHOWN = 80
_SHOWN_DEPTH = 3


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
