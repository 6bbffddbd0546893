"""The `auth` message of rosbridge: the token itself, or a MAC as rosauth makes it."""

from __future__ import annotations

import hashlib
from typing import Any

from rostether.gateways.websocket.admission import Token, is_same_secret

MAX_CLOCK_OFFSET_S = 5.0
"""How old a MAC may be, as in rosauth: a MAC that was overheard cannot be used later."""


def authenticates(token: Token, fields: dict[str, Any], now_s: float) -> bool:
    """Return whether an `auth` message is good: with the token itself, or rosauth's MAC made with it."""
    given = fields.get("token")
    if isinstance(given, str):
        return token.is_same(given)
    names = ("client", "dest", "rand", "t", "level", "end")
    mac, parts = fields.get("mac"), [fields.get(name) for name in names]
    if not isinstance(mac, str) or not all(isinstance(part, str | int | float) for part in parts):
        return False
    try:
        sent_s, end_s = float(fields["t"]), float(fields["end"])
    except (ValueError, OverflowError):
        return False
    text = token.secret + "".join(map(str, parts))
    expected = hashlib.sha512(text.encode("utf-8", "surrogatepass")).hexdigest()
    is_fresh = abs(now_s - sent_s) <= MAX_CLOCK_OFFSET_S and end_s > now_s
    return is_same_secret(mac.lower(), expected) and is_fresh
