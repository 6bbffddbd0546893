"""The recording requests of one client."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from rostether.errors import RostetherError
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.client_messages import (
    ListRecordings,
    PausePlayback,
    PlayRecording,
    StartRecording,
    StopPlayback,
    StopRecording,
)
from rostether.gateways.foxglove.client_work import ClientWork
from rostether.gateways.foxglove.foxglove_context import FoxgloveContext
from rostether.gateways.foxglove.recording_control import RecordingControl

# Concurrent requests of one client; a user makes one at a time.
MAX_REQUESTS = 4


class ClientRecordings:
    """Handles one client's requests about recordings.

    `send` sends a message to the client, and `report_error` reports an error.
    """

    def __init__(
        self,
        context: FoxgloveContext,
        work: ClientWork,
        send: Callable[[str], None],
        report_error: Callable[[str], None],
    ) -> None:
        self._context = context
        self._work = work
        self._send = send
        self._report_error = report_error
        self._changes = 0

    def follow(self, _: ListRecordings) -> None:
        """Report the recordings, now and when they change."""
        if (reports := self._context.recordings) is None:
            self._refuse()
            return
        reports.follow(self._report)
        self._work.ask(reports.report, self._report_error, MAX_REQUESTS, "requests about recordings")

    def start(self, request: StartRecording) -> None:
        """Start a recording."""
        self._change(lambda control: control.start(request.topics, request.format))

    def stop(self, _: StopRecording) -> None:
        """End the recording."""
        self._change(lambda control: control.stop())

    def play(self, request: PlayRecording) -> None:
        """Play a recording."""
        name, start_s, rate = request.name, request.start_s, request.rate
        self._change(lambda control: control.play(name, start_s, rate, is_prefixed=request.is_prefixed))

    def pause(self, request: PausePlayback) -> None:
        """Pause the playback, or continue it."""
        self._change(lambda control: control.pause(is_paused=request.is_paused))

    def stop_playing(self, _: StopPlayback) -> None:
        """End the playback."""
        self._change(lambda control: control.stop_playing())

    def close(self) -> None:
        """Stop reporting."""
        if self._context.recordings is not None:
            self._context.recordings.unfollow(self._report)

    def _change(self, change: Callable[[RecordingControl], Awaitable[None]]) -> None:
        reports = self._context.recordings
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
                await change(reports.control)
            except RostetherError as error:
                self._report_error(str(error))
            finally:
                self._changes -= 1
            await reports.report()

        # The request is finished even if the client disconnects.
        self._context.run(work())

    def _refuse(self) -> None:
        self._report_error("this gateway does not record; use `rostether dashboard`")

    def _report(self, state: Mapping[str, Any]) -> None:
        self._send(replies.recordings(state))
