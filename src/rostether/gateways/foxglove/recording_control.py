"""Recording at a client's request: the Protocol of a recorder, and reports to clients."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from rostether.errors import RostetherError
from rostether.mechanisms.tasks import cancel_all

# How often the size of a running recording is reported.
PERIOD_S = 1.0


class RecordingControl(Protocol):
    """Records the graph into a folder, and plays from it; one recording at a time."""

    @property
    def is_active(self) -> bool:
        """Whether a recording runs."""

    async def start(self, topics: Sequence[str], form: str) -> None:
        """Record topics, or all if none are given, as `bag` or `mcap`. Raises RostetherError."""

    async def stop(self) -> None:
        """End the recording, and close its file. Raises RostetherError."""

    @property
    def is_playing(self) -> bool:
        """Whether a recording is played or paused."""

    async def play(self, name: str, start_s: float, rate: float, *, is_prefixed: bool) -> None:
        """Play a recording from a time, under its own names or below a prefix. Raises RostetherError."""

    async def pause(self, *, is_paused: bool) -> None:
        """Pause the playback, or continue it. Raises RostetherError."""

    async def stop_playing(self) -> None:
        """End the playback, if there is one."""

    async def state(self) -> Mapping[str, Any]:
        """Return the current recording and playback, and the finished files, for JSON."""


class RecordingReports:
    """Reports the recordings to the clients that requested them, when they change and while one runs."""

    def __init__(self, control: RecordingControl) -> None:
        self.control = control
        self._followers: dict[Callable[[Mapping[str, Any]], None], None] = {}
        self._task: asyncio.Task[None] | None = None

    def follow(self, report: Callable[[Mapping[str, Any]], None]) -> None:
        """Start reporting to a client."""
        self._followers[report] = None

    def unfollow(self, report: Callable[[Mapping[str, Any]], None]) -> None:
        """Stop reporting to a client."""
        self._followers.pop(report, None)

    async def report(self) -> None:
        """Report now, and repeatedly while a recording runs."""
        state = await self.control.state()
        for report in list(self._followers):
            report(state)
        if self._is_running and (self._task is None or self._task.done()):
            self._task = asyncio.ensure_future(self._keep_reporting())

    async def close(self) -> None:
        """End the reports, the playback and the recording."""
        self._followers.clear()
        if self._task is not None:
            await cancel_all(self._task)
        await self.control.stop_playing()
        if self.control.is_active:
            with contextlib.suppress(RostetherError):
                await self.control.stop()

    @property
    def _is_running(self) -> bool:
        return self.control.is_active or self.control.is_playing

    async def _keep_reporting(self) -> None:
        is_running = True
        while is_running:
            await asyncio.sleep(PERIOD_S)
            # Report again after the end.
            is_running = self._is_running
            try:
                state = await self.control.state()
            except RostetherError as error:
                state = {"error": str(error)}
            for report in list(self._followers):
                report(state)
