"""Admits connections to the servers of a ROS graph: the master's, and XML-RPC and TCPROS of every node.

ROS 1 has no passwords, so only the address distinguishes peers. All servers of a process share one admission,
so that a scan of them is one line in the log.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable

from rostether.transports.allow_list import AllowList
from rostether.transports.refusals import RefusalLog


class Admission:
    """Admits connections from `networks` and from this machine; without networks, all.

    Raises ValueError for a text that is not a network.
    """

    def __init__(self, networks: Iterable[str] = ()) -> None:
        self._allow = AllowList(networks)
        self.refusals = RefusalLog("the ROS graph's servers", time.monotonic)

    def admits(self, transport: asyncio.BaseTransport) -> bool:
        """Return whether a connection may stay; otherwise it is closed before a byte of it is read."""
        if not self._allow.is_limiting:
            return True
        peer = transport.get_extra_info("peername")
        own = transport.get_extra_info("sockname")
        if not peer or self._allow.allows_connection(peer[0], own[0] if own else ""):
            return True
        self.refusals.refuse(peer[0], "its address is not in --allow")
        # uvloop's transports are not subclasses of asyncio's.
        abort: Callable[[], None] = transport.abort  # type: ignore[attr-defined]
        abort()
        return False


ALLOW_ALL = Admission()
