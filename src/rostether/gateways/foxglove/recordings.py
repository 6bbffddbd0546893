"""Recording for clients: the Protocol of a recorder, a client's requests, and reports to clients."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from typing import Any, Protocol

from rostether.errors import RostetherError
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.client_messages import (
    Action,
    ListRecordings,
    PausePlayback,
    PlayRecording,
    StartRecording,
    StopPlayback,
    StopRecording,
)
from rostether.gateways.foxglove.client_work import ClientWork
from rostether.mechanisms.tasks import cancel_all

# How often the size of a running recording is reported.
PERIOD_S = 1.0

# Concurrent requests of one client; a user makes one at a time.
MAX_REQUESTS = 4


class PlaybackControl(Protocol):
    """Plays one recording at a time."""

    @property
    def is_active(self) -> bool:
        """Whether a recording is played or paused."""

    async def play(self, name: str, start_s: float, rate: float, *, is_prefixed: bool) -> None:
        """Play a recording from a time, under its own names or below a prefix. Raises RostetherError."""

    async def pause(self, *, is_paused: bool) -> None:
        """Pause the playback, or continue it. Raises RostetherError."""

    async def stop(self) -> None:
        """End the playback, if there is one."""


class RecordingControl(Protocol):
    """Records the graph into a folder, one recording at a time; `playback` plays from it."""

    @property
    def playback(self) -> PlaybackControl:
        """The player of the recordings."""

    @property
    def is_active(self) -> bool:
        """Whether a recording runs."""

    async def start(self, topics: Sequence[str], form: str) -> None:
        """Record topics, or all if none are given, as `bag` or `mcap`. Raises RostetherError."""

    async def stop(self) -> None:
        """End the recording, and close its file. Raises RostetherError."""

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
        await self.control.playback.stop()
        if self.control.is_active:
            with contextlib.suppress(RostetherError):
                await self.control.stop()

    @property
    def _is_running(self) -> bool:
        return self.control.is_active or self.control.playback.is_active

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


_CHANGES: Mapping[type[Action], Callable[[RecordingControl, Any], Awaitable[None]]] = {
    StartRecording: lambda control, request: control.start(request.topics, request.format),
    StopRecording: lambda control, _: control.stop(),
    PlayRecording: lambda control, request: control.playback.play(
        request.name, request.start_s, request.rate, is_prefixed=request.is_prefixed
    ),
    PausePlayback: lambda control, request: control.playback.pause(is_paused=request.is_paused),
    StopPlayback: lambda control, _: control.playback.stop(),
}


class ClientRecordings:
    """Handles one client's requests about recordings.

    `send` sends a message to the client, `report_error` reports an error, and `run` completes work even if
    the client disconnects.
    """

    def __init__(
        self,
        reports: RecordingReports | None,
        work: ClientWork,
        send: Callable[[str], None],
        report_error: Callable[[str], None],
        run: Callable[[Coroutine[Any, Any, None]], None],
    ) -> None:
        self._reports = reports
        self._work = work
        self._send = send
        self._report_error = report_error
        self._run = run
        self._changes = 0
        self.handlers: dict[type, Callable[[Any], None]] = {
            ListRecordings: self._follow,
            **dict.fromkeys(_CHANGES, self._change),
        }

    def close(self) -> None:
        """Stop reporting."""
        if self._reports is not None:
            self._reports.unfollow(self._report)

    def _follow(self, _: ListRecordings) -> None:
        if self._reports is None:
            self._refuse()
            return
        self._reports.follow(self._report)
        self._work.ask(self._reports.report, self._report_error, MAX_REQUESTS, "requests about recordings")

    def _change(self, request: Action) -> None:
        reports = self._reports
        if reports is None:
            self._refuse()
            return
        if self._changes >= MAX_REQUESTS:
            self._report_error(
                f"more than {MAX_REQUESTS} requests about recordings at once; wait for the responses"
            )
            return
        self._changes += 1

        async def work() -> None:
            try:
                await _CHANGES[type(request)](reports.control, request)
            except RostetherError as error:
                self._report_error(str(error))
            finally:
                self._changes -= 1
            await reports.report()

        self._run(work())

    def _refuse(self) -> None:
        self._report_error("this gateway does not record; use `rostether dashboard`")

    def _report(self, state: Mapping[str, Any]) -> None:
        self._send(replies.recordings(state))
