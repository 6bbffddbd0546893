"""Reports a command's state to the service manager that started it, as sd_notify(3) describes."""

from __future__ import annotations

import asyncio
import os
import socket
from collections.abc import Coroutine
from contextlib import suppress
from typing import Any, TypeVar

T = TypeVar("T")


async def reporting(main: Coroutine[Any, Any, T]) -> T:
    """Return the result of `main`; while its loop runs, send READY=1 and WATCHDOG=1 to NOTIFY_SOCKET.

    The watchdog's period is half of WATCHDOG_USEC. A loop that is held sends nothing.
    """
    # The programs that this one starts have no part in it.
    address = os.environ.pop("NOTIFY_SOCKET", "")
    if not address:
        return await main
    if address.startswith("@"):
        address = f"\0{address[1:]}"
    limit_us = os.environ.pop("WATCHDOG_USEC", "")
    period_s = int(limit_us) / 2e6 if limit_us.isdecimal() else None
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notifications:
        notifications.setblocking(False)

        def send(state: bytes) -> None:
            # A manager that is gone or slow must not end its service.
            with suppress(OSError):
                notifications.sendto(state, address)

        async def keep_alive() -> None:
            send(b"READY=1")
            while period_s is not None:
                send(b"WATCHDOG=1")
                await asyncio.sleep(period_s)

        alive = asyncio.create_task(keep_alive())
        try:
            return await main
        finally:
            alive.cancel()
            send(b"STOPPING=1")
