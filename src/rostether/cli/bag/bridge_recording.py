"""What a bridge records: all topics of the graph into bags (`--record`), and the bytes on its lines."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.bag.formatting import MEGABYTE, size_text
from rostether.cli.bag.recording_files import create_folder
from rostether.cli.shell.option_group import COUNT, PATH, NumberRange, add_option, option
from rostether.errors import ConfigError, GraphError, RecordingError
from rostether.graph.ports import Level
from rostether.mechanisms.block_end import closed_at_end, task_beside
from rostether.mechanisms.tasks import run_until
from rostether.mechanisms.text import counted

if TYPE_CHECKING:
    from rostether.bridge.reporter import Reporter
    from rostether.graph.ports import JoinGraph
    from rostether.recording.recorded import RecordingWriter
    from rostether.ros2.types.type_support import Ros2Types
    from rostether.transports.transport import Transport

# A board's node retries at the same interval.
MAX_JOIN_RETRY_S = 1.0


@dataclass(frozen=True, slots=True)
class BagRecording:
    """The folder of the bags, None without --record; their size, and how many to keep, None for all."""

    folder: Path | None = option(
        "--record DIR", "Record all topics of the graph into bags in this folder.", type=PATH
    )
    size_mb: float = option(
        "--record-size MB",
        "With --record: start a new bag at this size (default: 1000).",
        type=NumberRange(min=0.1),
        default=1000,
    )
    keep: int | None = option(
        "--record-keep COUNT",
        "With --record: keep only the newest COUNT bags of this run (default: all).",
        type=COUNT,
    )

    def create_folder(self) -> None:
        """Create the folder if it does not exist. Raises ConfigError."""
        folder = self.folder
        if folder is None:
            return
        if folder.suffix in (".jsonl", ".json", ".bag", ".mcap") or folder.is_file():
            raise ConfigError(
                f"--record {folder}: give a folder, for bags of all topics; --record-line FILE records the "
                "bytes on the boards' lines"
            )
        create_folder(folder)


@asynccontextmanager
async def bags_recorded(
    recording: BagRecording, join: JoinGraph, reporter: Reporter, *, types: Ros2Types | None = None
) -> AsyncIterator[None]:
    """Record until the end of the block; a failure is reported and stops only the recording.

    On ROS 2 alone, `types` are the types of the graph, and the recording is a ROS 2 bag.
    """
    if recording.folder is None:
        yield
        return
    async with task_beside(_record(recording.folder, recording, join, reporter, types)):
        yield


async def _record(
    folder: Path, recording: BagRecording, join: JoinGraph, reporter: Reporter, types: Ros2Types | None
) -> None:
    from rostether.mechanisms.anonymous import anonymous_name
    from rostether.mechanisms.waiting import wait_for_master
    from rostether.recording.recorder import Recorder
    from rostether.recording.recording_plan import RecordLimits, TopicChoice

    node_name = anonymous_name("record")
    try:
        create, name = _files(folder, types)
    except RecordingError as error:
        reporter.report(Level.ERROR, f"{error}; boards stay connected")
        return
    joined = await wait_for_master(
        lambda: join(node_name),
        lambda error: reporter.report(Level.WARN, f"Recording starts when the graph is available: {error}"),
        max_retry_s=MAX_JOIN_RETRY_S,
        errors=GraphError,
    )
    async with closed_at_end(joined) as graph:
        recorder = Recorder(
            graph,
            TopicChoice(is_all=True, with_hidden=types is None),
            RecordLimits(
                size_bytes=round(recording.size_mb * MEGABYTE), is_splitting=True, max_splits=recording.keep
            ),
            create=create,
            name=name,
            report=lambda text: reporter.report(_level_of(text), text),
            repeat_latched=True,
        )
        try:
            await run_until(recorder.run(), graph.wait_closed())
        except RecordingError as error:
            reporter.report(Level.ERROR, f"{error}; boards stay connected")
        finally:
            count, size = recorder.progress.message_count, size_text(recorder.size_bytes)
            reporter.report(Level.INFO, f"Recorded {counted(count, 'message')}, {size}, in {folder}")


def _files(
    folder: Path, types: Ros2Types | None
) -> tuple[Callable[[Path], RecordingWriter], Callable[[int], Path]]:
    """Return a function that creates a file, and one that returns the path of a file, given its number."""
    from rostether.recording.files import create_recording, dated_name

    date = dated_name()
    if types is None:
        return create_recording, lambda number: folder / f"{date}_{number}.bag"
    from rostether.recording.ros2.bag_writer import Ros2Bag

    bag = Ros2Bag(folder / f"rosbag2_{date}", types=types)
    return bag.create, bag.path_of


def _level_of(text: str) -> Level:
    if text.startswith("WARNING: "):
        return Level.WARN
    # Lines for all new topics would hide the lines of the boards.
    return Level.DEBUG if text.startswith("Subscribing to ") else Level.INFO


record_limit_option = add_option(
    "--record-limit record_limit_mb MB",
    "Stop recording, but keep serving, when the file reaches this size (default: 100).",
    type=NumberRange(min=0.01),
    default=100,
)


@asynccontextmanager
async def recorded(
    path: Path | None, limit_mb: float, reporter: Reporter
) -> AsyncIterator[Callable[[Transport], Transport] | None]:
    """Yield a function that records a transport into a new file, None without a path. Raises ConfigError."""
    if path is None:
        yield None
        return
    from datetime import UTC, datetime
    from importlib.metadata import version

    from rostether.transports.capture_writer import CaptureWriter

    writer = CaptureWriter(
        path,
        clock=asyncio.get_running_loop().time,
        description={
            "started": datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z"),
            "host": f"rostether {version('rostether')}",
        },
        limit_bytes=int(limit_mb * MEGABYTE),
        report=lambda text: reporter.report(Level.WARN, text),
    )
    reporter.report(Level.INFO, f"Recording the lines to {path}")
    try:
        yield writer.tap
    finally:
        writer.close()
        reporter.report(Level.INFO, f"{path} holds {size_text(writer.written_bytes)}")
