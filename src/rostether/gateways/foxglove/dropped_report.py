"""The status that shows a client how many messages it lost because it reads too slowly."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.gateways.foxglove import server_messages as outgoing
from rostether.gateways.foxglove.server_messages import StatusLevel

_STATUS_ID = "slow-client"

# How often a client gets the number of lost messages.
_PERIOD_S = 5.0


class DroppedReport:
    """Counts lost messages; the status is removed after some time without losses."""

    def __init__(self, send: Callable[[str], None]) -> None:
        self._send = send
        self.count = 0
        self._reported = 0
        self._timer: asyncio.TimerHandle | None = None

    def add(self, count: int) -> None:
        """Count lost messages; they are reported now, or with the next report."""
        self.count += count
        if self._timer is None:
            self._report()

    def close(self) -> None:
        """Report nothing more."""
        if self._timer is not None:
            self._timer.cancel()

    def _report(self) -> None:
        self._timer = None
        if self.count == self._reported:
            self._send(outgoing.remove_status([_STATUS_ID]))
            return
        self._reported = self.count
        text = f"this client reads too slowly: {self.count} messages were left out so far"
        self._send(outgoing.status(StatusLevel.WARNING, text, _STATUS_ID))
        self._timer = asyncio.get_running_loop().call_later(_PERIOD_S, self._report)
