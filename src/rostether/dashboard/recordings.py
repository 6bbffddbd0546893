"""Recordings that pages of the dashboard start, stop and download: bags in one folder."""

from __future__ import annotations

import asyncio
import contextlib
import re
import shutil
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rostether.dashboard.playback import Playback
from rostether.errors import ConfigError, InvalidNameError, RecordingError, RostetherError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import Graph
from rostether.mechanisms.tasks import cancel_all, run_until
from rostether.mechanisms.text import write_failure
from rostether.recording.files import create_recording, dated_name
from rostether.recording.recorded import RecordingWriter
from rostether.recording.recorder import Recorder
from rostether.recording.recording_plan import RecordLimits, TopicChoice

FORMS = ("bag", "mcap")

# A page must not fill the robot's disk: limits for one recording, for all, and free space.
MAX_FILE_BYTES = 1 << 30
MAX_FOLDER_BYTES = 10 << 30
MIN_FREE_BYTES = 1 << 30

# Names of topics; a robot has about a hundred.
MAX_TOPICS = 1000

# The limit of listed recordings; the newest are listed.
MAX_LISTED = 200

_NAME = re.compile(r"[^.].*\.(?:bag|mcap)")


class Recordings:
    """One folder of recordings; `join` makes the node that records, and the one that plays."""

    def __init__(
        self,
        folder: Path,
        join: Callable[[], Awaitable[Graph]],
        report: Callable[[str], None],
        create: Callable[[Path], RecordingWriter] = create_recording,
    ) -> None:
        self.playback = Playback(self.find, join)
        self._folder = folder
        self._join = join
        self._report = report
        self._create = create
        self._lock = asyncio.Lock()
        self._recorder: Recorder | None = None
        self._task: asyncio.Task[None] | None = None
        self._began_s = 0.0
        self._name = ""
        self._failure = ""

    @property
    def is_active(self) -> bool:
        """Whether a recording runs."""
        return self._task is not None and not self._task.done()

    async def start(self, topics: Sequence[str], form: str) -> None:
        """Record topics, or all if none are given.

        Raises ConfigError, InvalidNameError, GraphError, RecordingError.
        """
        async with self._lock:
            if self.is_active:
                raise ConfigError(f"{self._name} is being recorded already; stop it first")
            if form not in FORMS:
                raise ConfigError(f"the form of a recording is {' or '.join(FORMS)}, not {form[:20]!r}")
            if len(topics) > MAX_TOPICS:
                raise ConfigError(f"at most {MAX_TOPICS} topics can be chosen; choose none to record all")
            await asyncio.to_thread(self._check_space)
            graph = await self._join()
            try:
                choice = TopicChoice(names=tuple(map(graph.resolve, topics)), is_all=not topics)
            except InvalidNameError:
                await graph.close()
                raise
            self._name = f"{dated_name()}.{form}"
            self._began_s, self._failure = time.monotonic(), ""
            self._recorder = Recorder(
                graph,
                choice,
                RecordLimits(size_bytes=MAX_FILE_BYTES),
                create=self._create,
                name=lambda _: self._folder / self._name,
                report=lambda _: None,
                repeat_latched=True,
            )
            started: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._task = asyncio.ensure_future(self._record(graph, self._recorder, started))
            await asyncio.wait([self._task, started], return_when=asyncio.FIRST_COMPLETED)
            if self._failure:
                raise RecordingError(self._failure)
            self._report(f"recording {self._folder / self._name}")

    async def stop(self) -> None:
        """End the recording, and complete its file. Raises ConfigError when none runs."""
        async with self._lock:
            if self._task is None or self._task.done():
                raise ConfigError("nothing is being recorded; start a recording first")
            await cancel_all(self._task)
            self._report(f"recorded {self._folder / self._name}")

    async def state(self) -> Mapping[str, Any]:
        """Return the running recording, the playback and the finished files, as values for JSON."""
        state: dict[str, Any] = {
            "active": None,
            "playing": self.playback.state(),
            "files": await asyncio.to_thread(self._files),
            "folder": str(self._folder),
        }
        if failure := self._failure or self.playback.pop_failure():
            state["error"] = failure
        if self.is_active and self._recorder is not None:
            state["active"] = {
                "name": self._name,
                "seconds": round(time.monotonic() - self._began_s, 1),
                "messages": self._recorder.progress.message_count,
                "topics": self._recorder.topic_count,
                "bytes": self._recorder.size_bytes,
            }
        return state

    def find(self, name: str) -> Path | None:
        """Return the file of a finished recording, None if there is none; reads the folder."""
        # Only names that this folder lists are valid: no path leads out of it.
        return next((file for file in self._finished() if file.name == name), None)

    async def _record(self, graph: Graph, recorder: Recorder, started: asyncio.Future[None]) -> None:
        async def fail_with_node() -> None:
            reason = await graph.wait_closed()
            self._failure = f"the node that records was shut down: {reason}; start the recording again"

        try:
            # The file is completed, however the recording ends.
            await run_until(recorder.run(lambda: started.set_result(None)), fail_with_node())
        except Exception as error:  # noqa: BLE001 - a defect of the recorder must not end the dashboard
            self._failure = str(error)
            if not isinstance(error, RostetherError):
                report_error(f"recording {self._name}", error)
        finally:
            with contextlib.suppress(RostetherError):
                await graph.close()

    def _check_space(self) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            free_bytes = shutil.disk_usage(self._folder).free
            used_bytes = sum(file.stat().st_size for file in self._finished())
        except OSError as error:
            raise ConfigError(write_failure(self._folder, error)) from None
        if free_bytes < MIN_FREE_BYTES + MAX_FILE_BYTES:
            raise ConfigError(f"only {free_bytes >> 20} MiB are free in {self._folder}; delete some files")
        if used_bytes > MAX_FOLDER_BYTES:
            raise ConfigError(
                f"the recordings in {self._folder} take up {used_bytes >> 30} GiB; delete or move some"
            )

    def _finished(self) -> list[Path]:
        try:
            return [
                file
                for file in self._folder.iterdir()
                # A page cannot show other names.
                if _NAME.fullmatch(file.name)
                and file.name.isprintable()
                and file.is_file()
                and not file.is_symlink()
            ]
        except OSError:
            return []

    def _files(self) -> list[dict[str, Any]]:
        files: list[dict[str, Any]] = []
        for file in self._finished():
            with contextlib.suppress(OSError):
                facts = file.stat()
                files.append({"name": file.name, "bytes": facts.st_size, "time": round(facts.st_mtime, 3)})
        return sorted(files, key=lambda each: (each["time"], each["name"]), reverse=True)[:MAX_LISTED]
