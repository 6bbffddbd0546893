"""The addresses of this machine that no other machine can reach."""

from __future__ import annotations

import re

# As a number: peers then need no resolver, and do not try ::1 first.
LOOPBACK = "127.0.0.1"


def is_loopback(host: str) -> bool:
    """Return whether a host name or address is loopback, without asking a resolver."""
    return host in ("localhost", "::1") or bool(re.fullmatch(r"127(\.\d{1,3}){3}", host))
