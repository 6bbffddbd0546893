"""Records topics of a graph: chooses topics, starts new files, and ends at the limits.

Payloads pass from the subscription to the writer unchanged, in the same batches. Each publisher has
its own connection in the file if the graph distinguishes publishers (ROS 1).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rostether.errors import RecordingError
from rostether.graph.joint_marks import is_mark
from rostether.graph.ports import Graph, OnMessages, Snapshot, Subscriber
from rostether.mechanisms.tasks import occurs_within
from rostether.msgdef.interface import ANY_MESSAGE, ANY_TYPE
from rostether.recording.background_writer import BackgroundWriter
from rostether.recording.file_lock import ACTIVE_SUFFIX, FileLock, end_active, lock_active
from rostether.recording.recorded import Connection, RecordingWriter
from rostether.recording.recording_plan import RecordingProgress, RecordLimits, TopicChoice
from rostether.recording.recording_start import report_missing, wait_for_time

# A killed process loses at most this time; each flush of a slow topic costs a chunk's 200 bytes.
FLUSH_PERIOD_S = 0.5


class Recorder:
    """One recording; `create` opens a file's writer, `name` returns the path of the file with a number.

    `report` gets lines for users: new topics and files, and problems. With `repeat_latched`, each new file
    starts with the last latched messages. With `buffer_bytes`, writers run in a thread, which compression
    needs, and at most this much data waits for them.
    """

    def __init__(
        self,
        graph: Graph,
        choice: TopicChoice,
        limits: RecordLimits,
        *,
        create: Callable[[Path], RecordingWriter],
        name: Callable[[int], Path],
        report: Callable[[str], None],
        repeat_latched: bool = False,
        buffer_bytes: int | None = None,
    ) -> None:
        self.progress = RecordingProgress()
        self._graph = graph
        self._choice = choice
        self._limits = limits
        self._create = create
        self._name = name
        self._report = report
        self._buffer_bytes = buffer_bytes
        self._subscribers: dict[str, Subscriber] = {}
        self._connections: dict[str, Connection] = {}
        self._ended = asyncio.Event()
        self._failure: RecordingError | None = None
        self._path = Path()
        self._writer: RecordingWriter | None = None
        self._locks: dict[Path, FileLock] = {}
        self._last_ns = 0
        self._began_s = 0.0
        self._file_count = 0
        self._closings: list[asyncio.Task[None]] = []
        self._dropped: set[Path] = set()
        self._latched: dict[Connection, bytes] | None = {} if repeat_latched else None

    @property
    def size_bytes(self) -> int:
        """The total size of all files."""
        return self.progress.finished_bytes + (self._writer.size_bytes if self._writer is not None else 0)

    @property
    def topic_count(self) -> int:
        """How many topics the recorder subscribes to."""
        return len(self._subscribers)

    async def run(self, on_started: Callable[[], None] | None = None) -> None:
        """Record until canceled, or a limit is reached.

        `on_started` is called once, after the first subscriptions or before the wait for simulated time.
        Files are always closed, and keep their messages. Raises RecordingError if a write fails, and
        GraphError.
        """
        self._open()
        tasks: list[asyncio.Task[None]] = []
        try:
            if not self._graph.now().to_ns():
                if on_started is not None:
                    on_started()
                on_started = None
                await wait_for_time(self._graph, self._report)
                self._began_s = asyncio.get_running_loop().time()
            for name in self._choice.names:
                await self._subscribe(name)
            missing = report_missing(self._graph, self._choice.names, self._connections, self._report)
            tasks.append(asyncio.create_task(missing))
            if self._choice.is_searching:
                if not self._found(await self._graph.snapshot()):
                    self._report("no such topic yet: waiting for it")
                tasks.append(asyncio.create_task(self._search()))
            if on_started is not None:
                on_started()
            while not self._ended.is_set():
                await occurs_within(self._ended, FLUSH_PERIOD_S)
                self._flush()
        finally:
            for task in tasks:
                task.cancel()
            writer = self._writer
            # A graph that has ended must not keep the file open.
            await asyncio.gather(
                *(each.close() for each in self._subscribers.values()), return_exceptions=True
            )
            if writer is not None:
                self._finish()
            await asyncio.gather(*self._closings)
            if self._failure is not None:
                raise self._failure

    async def _search(self) -> None:
        async for snapshot in self._graph.changes():
            for name in self._found(snapshot):
                await self._subscribe(name)

    def _found(self, snapshot: Snapshot) -> list[str]:
        return [
            topic.name
            for topic in snapshot.topics.values()
            if topic.name not in self._subscribers
            and not is_mark(topic.name)
            and self._choice.includes(topic.name, topic.subscribers)
        ]

    async def _subscribe(self, topic: str) -> None:
        if topic in self._subscribers:
            return

        def connected(fields: Mapping[str, str]) -> OnMessages:
            connection = Connection.from_fields(topic, fields)
            self._connections[topic] = connection
            return lambda payloads: self._write(connection, payloads)

        def write(payloads: Sequence[bytes]) -> None:
            # This graph does not distinguish publishers.
            connection = self._connections.get(topic)
            if connection is not None:
                self._write(connection, payloads)

        self._subscribers[topic] = await self._graph.subscribe(
            topic, ANY_MESSAGE, write, on_connection=connected
        )
        self._report(f"Subscribing to {topic}")

    def _write(self, connection: Connection, payloads: Sequence[bytes]) -> None:
        if self._writer is None or connection.type.name == ANY_TYPE:
            return
        topic = connection.topic
        before = self.progress.counts.get(topic, 0)
        limit = self._limits.messages_per_topic
        if limit is not None and before + len(payloads) > limit:
            payloads = payloads[: max(limit - before, 0)]
        # Simulated time is zero until its first message.
        time_ns = self._graph.now().to_ns()
        if not time_ns or not payloads:
            return
        try:
            if time_ns < self._last_ns:
                # A simulation was reset. A chunk must not contain times from before and after it.
                self._writer.flush()
            self._last_ns = time_ns
            self._writer.write(self._writer.add_connection(connection), time_ns, payloads)
        except RecordingError as error:
            self._fail(error)
            return
        self.progress.counts[topic] = before + len(payloads)
        self.progress.message_count += len(payloads)
        self._file_count += len(payloads)
        if self._latched is not None and connection.is_latching:
            self._latched[connection] = payloads[-1]
        if self._limits.size_bytes is not None and self._writer.size_bytes >= self._limits.size_bytes:
            self._end_file()

    def _flush(self) -> None:
        if self._writer is None:
            return
        try:
            self._writer.flush()
        except RecordingError as error:
            self._fail(error)
            return
        duration_s = self._limits.duration_s
        if duration_s is not None and asyncio.get_running_loop().time() - self._began_s >= duration_s:
            self._end_file()
        limit = self._limits.messages_per_topic
        if limit is not None and not self._choice.is_searching:
            counts = self.progress.counts
            if all(counts.get(name, 0) >= limit for name in self._choice.names):
                self._ended.set()

    def _end_file(self) -> None:
        """End the recording, or start its next file."""
        if not self._limits.is_splitting:
            self._ended.set()
            return
        self._finish()
        if self._failure is not None:
            return
        try:
            self._open()
            self._repeat_latched()
        except RecordingError as error:
            self._fail(error)

    def _repeat_latched(self) -> None:
        writer = self._writer
        if writer is None:
            return
        now_ns = self._graph.now().to_ns()
        for connection, payload in (self._latched or {}).items():
            writer.write(writer.add_connection(connection), now_ns, [payload])
            self.progress.message_count += 1
            self._file_count += 1

    def _open(self) -> None:
        number = len(self.progress.files)
        self._path = self._name(number)
        active = self._path.with_name(self._path.name + ACTIVE_SUFFIX)
        lock = lock_active(active, self._path, self._report)
        try:
            writer = self._create(active)
        except BaseException:
            lock.release()
            raise
        self._locks[self._path] = lock
        if self._buffer_bytes is not None:
            writer = BackgroundWriter(writer, buffer_bytes=self._buffer_bytes, report=self._report)
        self._writer = writer
        self._began_s = asyncio.get_running_loop().time()
        self.progress.files.append(self._path)
        maximum = self._limits.max_splits
        if maximum is not None and number >= maximum:
            self._dropped.add(self.progress.files[number - maximum])
            self.progress.files[number - maximum].unlink(missing_ok=True)
        self._report(f"Recording to {self._path}")

    def _finish(self) -> None:
        writer, self._writer = self._writer, None
        if writer is None:
            return
        count, self._file_count = self._file_count, 0
        if isinstance(writer, BackgroundWriter):
            # Compressing the waiting messages may take seconds.
            self._closings.append(asyncio.create_task(self._close_later(writer, self._path, count)))
        else:
            self._close(writer, self._path, count)

    async def _close_later(self, writer: BackgroundWriter, path: Path, count: int) -> None:
        await asyncio.to_thread(writer.wait_closed)
        self._close(writer, path, count)

    def _close(self, writer: RecordingWriter, path: Path, count: int) -> None:
        try:
            writer.close()
        except RecordingError as error:
            reason = self._failure or f"{error}; recording stopped"
            self._failure = RecordingError(f"{reason}; `rostether bag reindex {path}` gives it an index")
            self._ended.set()
        # Messages that were not written are not counted.
        self.progress.message_count += writer.message_count - count
        self.progress.finished_bytes += writer.size_bytes
        try:
            end_active(path.with_name(path.name + ACTIVE_SUFFIX), path)
            if path in self._dropped:
                path.unlink()
        except OSError as error:
            is_gone = isinstance(error, FileNotFoundError)
            step = "do not move a file while it is recorded" if is_gone else "rename it yourself"
            self._failure = self._failure or RecordingError(
                f"cannot rename {path}{ACTIVE_SUFFIX} to {path.name}: {error.strerror or error}; {step}"
            )
            self._ended.set()
        finally:
            self._locks.pop(path).release()

    def _fail(self, error: RecordingError) -> None:
        self._failure = self._failure or RecordingError(
            f"{error}; recording stopped; {self._path} contains the messages until then"
        )
        self._finish()
        self._ended.set()
