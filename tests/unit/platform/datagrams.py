"""Multicast on loopback: a group and a port for each test, and a plain socket as the receiver."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator, Coroutine
from contextlib import asynccontextmanager
from typing import Any

from rostether.platform.multicast_socket import GroupAddress, join_group, open_receiver, open_sender

GROUP = "239.255.82.83"
GROUP_IPV6 = "ff15::5253"
LINK_GROUP = "ff02::5253"


def _ipv6_interface() -> str:
    """Return an interface with IPv6 multicast, or "" without one: loopback has no route for it."""
    for _, name in socket.if_nameindex():
        with contextlib.suppress(OSError), open_sender(GroupAddress(GROUP_IPV6, ttl=0), name) as sock:
            sock.sendto(b"", (GROUP_IPV6, 9))
            return name
    return ""


IPV6_INTERFACE = _ipv6_interface()
GROUPS = [GROUP, "127.0.0.1", *([GROUP_IPV6, LINK_GROUP] if IPV6_INTERFACE else [])]


def loopback_group(group: str = GROUP) -> GroupAddress:
    """Return a group on this machine, with a port that is free."""
    family = socket.AF_INET6 if ":" in group else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.bind(("::" if ":" in group else "", 0))
        interface = IPV6_INTERFACE if ":" in group else "lo"
        return GroupAddress(group, probe.getsockname()[1], (interface,), ttl=0)


class PlainReceiver:
    """Receives the datagrams of a group with a plain socket."""

    def __init__(self, address: GroupAddress) -> None:
        self.datagrams: list[bytes] = []
        self.sources: list[Any] = []
        self._socket = open_receiver(address)
        if address.is_multicast:
            join_group(self._socket, address, address.interfaces[0])
        asyncio.get_running_loop().add_reader(self._socket, self._read)

    def _read(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                data, source = self._socket.recvfrom(65536)
                self.datagrams.append(data)
                self.sources.append(source)

    def close(self) -> None:
        """Close the socket."""
        asyncio.get_running_loop().remove_reader(self._socket)
        self._socket.close()


@asynccontextmanager
async def running(*works: Coroutine[Any, Any, None]) -> AsyncIterator[list[asyncio.Task[None]]]:
    """Run nodes until the block ends; a node that fails fails the test."""
    tasks = [asyncio.ensure_future(each) for each in works]
    try:
        yield tasks
    finally:
        for task in tasks:
            task.cancel()
        results = await asyncio.gather(*tasks, return_exceptions=True)
    for result in results:
        if isinstance(result, Exception):
            raise result
