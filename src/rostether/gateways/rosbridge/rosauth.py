"""A client's proof that it knows the token: the token itself, or a MAC made with it, as in rosauth."""

from __future__ import annotations

import hashlib
from typing import Any

from rostether.gateways.websocket.access_rules import is_same_secret

# The maximum age of a MAC, as in rosauth: an intercepted MAC cannot be used later.
_MAX_CLOCK_OFFSET_S = 5.0


def authenticates(token: str, fields: dict[str, Any], now_s: float) -> bool:
    """Return whether an `auth` message is valid: with the token itself, or rosauth's MAC made with it."""
    given = fields.get("token")
    if isinstance(given, str):
        return is_same_secret(given, token)
    names = ("client", "dest", "rand", "t", "level", "end")
    mac, parts = fields.get("mac"), [fields.get(name) for name in names]
    if not isinstance(mac, str) or not all(isinstance(part, str | int | float) for part in parts):
        return False
    try:
        sent_s, end_s = float(fields["t"]), float(fields["end"])
    except (ValueError, OverflowError):
        return False
    text = token + "".join(map(str, parts))
    expected = hashlib.sha512(text.encode("utf-8", "surrogatepass")).hexdigest()
    is_fresh = abs(now_s - sent_s) <= _MAX_CLOCK_OFFSET_S and end_s > now_s
    return is_same_secret(mac.lower(), expected) and is_fresh
