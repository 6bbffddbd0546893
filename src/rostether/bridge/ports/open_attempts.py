"""Retries to open a link, for configured links and found ports."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeAlias

from rostether.errors import TransportError
from rostether.mechanisms.backoff import Backoff
from rostether.ports.board_identity import BoardIdentity
from rostether.transports.address import Address
from rostether.transports.transport import Transport

# udev sets the group of a new port, and ModemManager releases it, a moment after it appears: only an error
# that lasts longer is reported.
SETTLE_S = 1.0

# Uses an open link until it ends; returns the error that ended it, None if the bridge ended it. Raises
# SessionError if it must not be served again.
ServeLink: TypeAlias = Callable[[Address, Transport, BoardIdentity], Awaitable[TransportError | None]]


class OpenAttempts:
    """Paces the attempts to open a link, and reports each new reason why they fail.

    `settle_s` is the time from the first attempt during which nothing is reported.
    """

    def __init__(
        self, backoff: Backoff, report: Callable[[str], object], *, settle_s: float = SETTLE_S
    ) -> None:
        self._backoff = backoff
        self._report = report
        self._report_at_s = asyncio.get_running_loop().time() + settle_s
        self._reported = ""

    async def wait_after(self, reason: str) -> None:
        """Report why an attempt failed, unless that was the last report, and wait for the next attempt."""
        if reason != self._reported and asyncio.get_running_loop().time() >= self._report_at_s:
            self._reported = reason
            self._report(reason)
        await asyncio.sleep(self._backoff.next_delay_s())
