"""Plays one recording at a time; a page of the dashboard chooses the recording and the start time."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from rostether.errors import ConfigError, RostetherError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import Graph
from rostether.mechanisms.tasks import cancel_all, run_until
from rostether.recording.files import open_recording
from rostether.recording.player import Player, PlaySettings
from rostether.recording.recorded import RecordingReader
from rostether.rostime import NS_PER_S

_MIN_RATE, _MAX_RATE = 0.1, 10.0

# Recorded commands must not drive the robot by accident.
PREFIX = "/playback"


class Playback:
    """Plays files that `find` finds by name; `join` makes the node that plays."""

    def __init__(self, find: Callable[[str], Path | None], join: Callable[[], Awaitable[Graph]]) -> None:
        self._find = find
        self._join = join
        self._lock = asyncio.Lock()
        self._task: asyncio.Task[None] | None = None
        self._player: Player | None = None
        self._settings = PlaySettings()
        self._name = ""
        self._failure = ""

    @property
    def is_active(self) -> bool:
        """Whether a recording is played or paused."""
        return self._task is not None and not self._task.done()

    async def play(self, name: str, start_s: float, rate: float, *, is_prefixed: bool) -> None:
        """Play a recording, below `PREFIX` or under its own names. Raises the same errors as `start`."""
        prefix = PREFIX if is_prefixed else ""
        await self.start(name, PlaySettings(rate=rate, start_s=start_s, prefix=prefix))

    async def start(self, name: str, settings: PlaySettings) -> None:
        """Play a recording, after ending the current one. Raises ConfigError, RecordingError, GraphError."""
        if not _MIN_RATE <= settings.rate <= _MAX_RATE:
            raise ConfigError(f"the rate must be from {_MIN_RATE:g} to {_MAX_RATE:g}, not {settings.rate:g}")
        async with self._lock:
            await self._end()
            path = await asyncio.to_thread(self._find, name)
            if path is None:
                raise ConfigError(f"there is no recording {name[:100]!r}; choose another one")
            reader = await asyncio.to_thread(open_recording, path)
            self._name, self._settings, self._failure = name, settings, ""
            started: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._task = asyncio.ensure_future(self._play(reader, started))
            await asyncio.wait([self._task, started], return_when=asyncio.FIRST_COMPLETED)
            if not started.done():
                self._task.result()

    async def pause(self, *, is_paused: bool) -> None:
        """Pause or continue. Raises ConfigError when nothing is played."""
        if self._player is None or not self.is_active:
            raise ConfigError("nothing is being played; play a recording first")
        if self._player.is_paused != is_paused:
            self._player.toggle_pause()

    async def stop(self) -> None:
        """End the playback, if there is one."""
        async with self._lock:
            await self._end()

    def state(self) -> dict[str, Any] | None:
        """Return the file and position of the playback for JSON, None if there is no playback."""
        player = self._player
        if player is None or not self.is_active:
            return None
        passed_s = max(player.time_ns - player.start_ns, 0) / NS_PER_S
        return {
            "name": self._name,
            "seconds": round(self._settings.start_s + passed_s, 2),
            "length": round(player.length_s, 2),
            "rate": self._settings.rate,
            "paused": player.is_paused,
            "prefix": self._settings.prefix,
        }

    def pop_failure(self) -> str:
        """Return why the last playback failed, and clear it; an empty string if it did not."""
        failure, self._failure = self._failure, ""
        return failure

    async def _end(self) -> None:
        if self._task is not None:
            await cancel_all(self._task)
            self._task = None

    async def _play(self, reader: RecordingReader, started: asyncio.Future[None]) -> None:
        with contextlib.closing(reader):
            graph = await self._join()
            try:
                self._player = player = Player(graph, [reader], self._settings)
                started.set_result(None)
                await run_until(player.play(), graph.wait_closed())
            except RostetherError as error:
                if not started.done():
                    raise
                self._failure = str(error)
            except Exception as error:  # noqa: BLE001 - a defect of the player must not end the dashboard
                report_error(f"playing {self._name}", error)
            finally:
                with contextlib.suppress(RostetherError):
                    await graph.close()
