"""Checks the host name under which this machine's nodes register: other nodes connect to it."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable

from rostether.transports.own_names import is_address


def describe_unknown_host(host: str) -> str:
    """Return what is wrong with an advertised host name that has no address, and what to do."""
    return (
        f"this machine does not know the host name {host} (ROS_HOSTNAME): other nodes cannot connect to it; "
        "set ROS_IP to this machine's address instead, or add the name to /etc/hosts"
    )


def check_own_host(host: str, report: Callable[[str], None]) -> None:
    """Look up a host name in the background, and report in the event loop if it has no address."""
    if is_address(host) or host == "localhost":
        return
    loop = asyncio.get_running_loop()

    def look_up() -> None:
        try:
            socket.getaddrinfo(host, None)
        except (OSError, UnicodeError):
            # The program may have ended in the meantime.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(report, describe_unknown_host(host))

    # A daemon thread: a resolver may take longer than a short command.
    threading.Thread(target=look_up, name="host name", daemon=True).start()
