"""Explains why JSON does not fit a msgspec type, in the words of JSON."""

from __future__ import annotations

import re

# The names of msgspec, which are Python's, and those of JSON.
_NAMES = {"str": "string", "int": "integer", "float": "number", "bool": "boolean", "|": "or"}


def explain_fault(error: Exception) -> str:
    """Return the reason of an error of msgspec, after its place: `baud: expected integer, got string`."""
    if isinstance(error, UnicodeDecodeError):
        return f"not UTF-8 text at byte {error.start}"
    reason, _, place = str(error).partition(" - at `$")
    reason = re.sub(r"`([^`]*)`", lambda quoted: re.sub(r"\w+|\|", _translated, quoted[1]), reason)
    if not reason.startswith("JSON"):
        reason = reason[:1].lower() + reason[1:]
    return f"{place.strip('`.')}: {reason}" if place else reason


def _translated(word: re.Match[str]) -> str:
    return _NAMES.get(word[0], word[0])
