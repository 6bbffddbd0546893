"""Listens for an IGMP querier (RFC 3376): without one, switches forget the members of a group."""

from __future__ import annotations

import asyncio
import socket
import sys

from rostether.mechanisms.tasks import occurs_within
from rostether.transports.sockets import new_socket

# A querier asks all machines at least this often (RFC 3376, 8.2: 125 s), and may be a little late.
QUERY_INTERVAL_S = 130.0

_MEMBERSHIP_QUERY = 0x11

# Longer than an IP header with an IGMP message. After a burst of packets, other tasks run.
_MAX_IGMP_BYTES = 2048
_BURST = 100


async def has_querier(interfaces: tuple[str, ...], duration_s: float) -> bool | None:
    """Return whether an IGMP query arrives in this time, at one of the interfaces if there are any.

    Returns None if it cannot listen: it needs root or CAP_NET_RAW, and an existing interface.
    """
    received = asyncio.Event()
    sockets: list[socket.socket] = []
    loop = asyncio.get_running_loop()
    try:
        try:
            sockets.extend(_open_igmp(each) for each in interfaces or ("",))
        except OSError:
            return None
        for sock in sockets:
            loop.add_reader(sock, _read_igmp, sock, received)
        return await occurs_within(received, duration_s)
    finally:
        for sock in sockets:
            loop.remove_reader(sock)
            sock.close()


def _open_igmp(interface: str) -> socket.socket:
    with new_socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_IGMP) as sock:
        # An interface that is given by its address has no name to bind to: queries on all interfaces count.
        if interface and interface.count(".") != 3 and sys.platform == "linux":
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, interface.encode())
    return sock


def _read_igmp(sock: socket.socket, received: asyncio.Event) -> None:
    for _ in range(_BURST):
        try:
            packet = sock.recv(_MAX_IGMP_BYTES)
        except OSError:
            return
        # The IP header, whose length is in 4-byte words, comes first.
        igmp = packet[4 * (packet[0] & 0x0F) :] if packet else b""
        if igmp and igmp[0] == _MEMBERSHIP_QUERY:
            received.set()
