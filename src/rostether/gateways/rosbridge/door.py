"""The door of a rosbridge server: how many connections there are, and from where, before a byte is read."""

from __future__ import annotations

import asyncio
from typing import Any

from websockets.asyncio.server import ServerConnection

from rostether.gateways.rosbridge.admission import Admission
from rostether.gateways.rosbridge.settings import MAX_CLIENTS
from rostether.gateways.rosbridge.status import clean_line
from rostether.gateways.rosbridge.surroundings import Tell
from rostether.graph.ports import Level

MAX_GREETING = 256
"""Connections that have not said what they want yet; websockets gives each ten seconds for that."""

QUIET_S = 10.0
"""A page that may not connect tries again every second; one line now and then tells as much."""


class Door:
    """Lets connections in and tells of those that it refuses, at most every ten seconds."""

    def __init__(self, admission: Admission, tell: Tell) -> None:
        self.open_count = 0
        self._admission = admission
        self._tell = tell
        self._quiet_until_s = 0.0
        self._unsaid = 0

    def refuses(self, transport: asyncio.BaseTransport) -> str:
        """Return why a connection may not stay; empty if it may."""
        peer, own = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if not peer or not own:
            return "it is gone"
        if not self._admission.allows_host(peer[0], own[0]):
            return f"{peer[0]} is not in the networks of --allow"
        if self.open_count >= MAX_CLIENTS + MAX_GREETING:
            return f"{self.open_count} connections are the most"
        return ""

    def tell_refusal(self, peer: str, reason: str) -> None:
        """Say that a peer was refused, unless that was said just now."""
        now_s = asyncio.get_running_loop().time()
        if now_s < self._quiet_until_s:
            self._unsaid += 1
            return
        more = f" ({self._unsaid} more since the last such line)" if self._unsaid else ""
        self._tell(Level.WARN, f"rosbridge: refused {peer}: {clean_line(reason)}{more}")
        self._quiet_until_s = now_s + QUIET_S
        self._unsaid = 0


class DoorConnection(ServerConnection):
    """A connection that went through the door, or is hung up on."""

    def __init__(self, door: Door, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._door = door
        self._is_counted = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take the connection, or end it before anything is read."""
        reason = self._door.refuses(transport)
        super().connection_made(transport)
        if reason:
            self._door.tell_refusal(peer_name(transport), reason)
            self.transport.abort()
            return
        self._is_counted = True
        self._door.open_count += 1

    def connection_lost(self, exc: Exception | None) -> None:
        """Free the place."""
        if self._is_counted:
            self._is_counted = False
            self._door.open_count -= 1
        super().connection_lost(exc)


def peer_name(transport: asyncio.BaseTransport) -> str:
    """Return a peer as people read it."""
    address = transport.get_extra_info("peername")
    if not address:
        return "a client"
    return f"[{address[0]}]:{address[1]}" if ":" in address[0] else f"{address[0]}:{address[1]}"
