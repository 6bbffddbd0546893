"""Limits the connections of a gateway by number and peer address, before a byte is read."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from rostether.mechanisms.text import fold_line, show_endpoint
from rostether.transports.allow_list import AllowList

# A page that may not connect retries every second; one log line in this time is enough.
QUIET_S = 10.0

# Reasons logged in that time: a refused client may cause a different one with each connection.
MAX_REASONS = 5


class ConnectionLimiter:
    """Admits and counts connections, and reports those that it refuses at a limited rate.

    `allow` are the networks that may connect (none: all networks). At most `max_connections` are open;
    `make_room` ends one of them when the limit is reached, and returns whether it did.
    """

    def __init__(
        self,
        allow: Sequence[str],
        max_connections: int,
        report: Callable[[str], None],
        make_room: Callable[[], bool] = lambda: False,
    ) -> None:
        self.open_count = 0
        self._allow = AllowList(allow)
        self._max_connections = max_connections
        self._report = report
        self._make_room = make_room
        self._reported: set[str] = set()
        self._reported_until_s = 0.0
        self._omitted_count = 0

    def admit(self, transport: asyncio.BaseTransport) -> bool:
        """Return whether a new connection is admitted, and count it until the caller calls `release`."""
        reason = self._refusal(transport)
        if reason:
            self.report_refusal(transport, reason)
            return False
        self.open_count += 1
        return True

    def release(self) -> None:
        """Stop counting an admitted connection."""
        self.open_count -= 1

    def report_refusal(self, transport: asyncio.BaseTransport, reason: str) -> None:
        """Report a refused connection, unless the rate limit of reports is reached."""
        now_s = asyncio.get_running_loop().time()
        if now_s >= self._reported_until_s:
            self._reported.clear()
            self._reported_until_s = now_s + QUIET_S
        if reason in self._reported or len(self._reported) >= MAX_REASONS:
            self._omitted_count += 1
            return
        self._reported.add(reason)
        more = f" ({self._omitted_count} more since the last such line)" if self._omitted_count else ""
        self._report(f"refused {peer_name(transport)}: {fold_line(reason)}{more}")
        self._omitted_count = 0

    def _refusal(self, transport: asyncio.BaseTransport) -> str:
        peer, own = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if not peer or not own:
            return "it has disconnected"
        if not self._allow.allows_connection(peer[0], own[0]):
            return f"{peer[0]} is not in the networks of --allow; add it there"
        if self.open_count >= self._max_connections and not self._make_room():
            return f"the limit of open connections ({self._max_connections}) is reached; close another one"
        return ""


def peer_name(transport: asyncio.BaseTransport) -> str:
    """Return a peer's address as text."""
    address = transport.get_extra_info("peername")
    return show_endpoint(*address[:2]) if address else "a client"
