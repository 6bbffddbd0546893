"""Recording on a client's demand: what a gateway asks of the recorder, and reports to its clients."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from rostether.errors import RostetherError

# While a recording runs, its size is reported so often.
PERIOD_S = 1.0


class RecordingControl(Protocol):
    """Records the graph into a folder, one recording at a time."""

    @property
    def is_active(self) -> bool:
        """Whether a recording runs."""

    async def start(self, topics: Sequence[str], form: str) -> None:
        """Record topics, all without any, as `bag` or `mcap`. Raises RostetherError."""

    async def stop(self) -> None:
        """End the recording, and close its file. Raises RostetherError."""

    async def state(self) -> Mapping[str, Any]:
        """Return the running recording and the finished files, as JSON has them."""


class RecordingReports:
    """Reports the recordings to the clients that asked for them, at changes and while one runs."""

    def __init__(self, control: RecordingControl) -> None:
        self.control = control
        self._followers: dict[Callable[[Mapping[str, Any]], None], None] = {}
        self._task: asyncio.Task[None] | None = None

    def follow(self, report: Callable[[Mapping[str, Any]], None]) -> None:
        """Report from now on."""
        self._followers[report] = None

    def unfollow(self, report: Callable[[Mapping[str, Any]], None]) -> None:
        """Report no more."""
        self._followers.pop(report, None)

    async def report(self) -> None:
        """Report now, and again and again while a recording runs."""
        state = await self.control.state()
        for report in list(self._followers):
            report(state)
        if self.control.is_active and (self._task is None or self._task.done()):
            self._task = asyncio.ensure_future(self._keep_reporting())

    async def close(self) -> None:
        """End the reports, and the recording."""
        self._followers.clear()
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait([self._task])
        if self.control.is_active:
            with contextlib.suppress(RostetherError):
                await self.control.stop()

    async def _keep_reporting(self) -> None:
        is_active = True
        while is_active:
            await asyncio.sleep(PERIOD_S)
            # Once more after its end.
            is_active = self.control.is_active
            try:
                state = await self.control.state()
            except RostetherError as error:
                state = {"error": str(error)}
            for report in list(self._followers):
                report(state)
