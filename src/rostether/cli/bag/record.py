"""`rostether bag record`: records topics into a file, until Ctrl-C or a limit."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import click

from rostether.cli.access.completions import complete_topics
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.ros1_access import read_environment, resolve
from rostether.cli.bag.formatting import MEGABYTE, size_text
from rostether.cli.bag.progress import ProgressLine
from rostether.cli.bag.recording_files import (
    asked_form,
    check_compression,
    format_option,
    new_path,
    recording_graph,
    storage_option,
)
from rostether.cli.shell.option_group import (
    COUNT,
    DURATION,
    NumberRange,
    flag,
    ignored_options,
    option,
    option_group,
    shared,
)
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.tasks import run_until
from rostether.mechanisms.text import counted, misfit_text

if TYPE_CHECKING:
    from rostether.graph.ports import Graph
    from rostether.recording.files import Form
    from rostether.recording.recorded import RecordingWriter
    from rostether.recording.recorder import Recorder
    from rostether.recording.recording_plan import RecordLimits, TopicChoice
    from rostether.recording.ros2.channels import UnfitMessages
    from rostether.ros2.types.type_support import Ros2Types

    Create: TypeAlias = Callable[[Path], RecordingWriter]

# As in rosbag.
BEGIN_TOPIC = "/begin_write"
# The buffer for -b 0, which means no limit in rosbag: a larger one could use up the memory of the machine.
MAX_BUFFER_MB = 4096
KILOBYTE = 1024


@dataclass(frozen=True, slots=True)
class RecordOptions:
    """The options of `bag record`."""

    records_all: bool = flag("-a --all", "Record all topics, including those that appear later.")
    has_patterns: bool = flag("-e --regex", "TOPICs are regular expressions.")
    exclude: str | None = option("-x --exclude REGEX", "Omit the topics that match.")
    node: str | None = option("--node NODE", "Record all topics that a node subscribes to.")
    output_name: str | None = option("-O --output FILE", "The .bag, .mcap or .db3 file, or folder.")
    output_prefix: str | None = option(
        "-o --output-prefix PREFIX", "Begin the file's name with PREFIX, followed by the date."
    )
    split: bool = flag("--split", "Start a new file whenever --size or --duration is reached.")
    max_splits: int | None = option("--max-splits COUNT", "Keep the newest COUNT files.", type=COUNT)
    size_mb: float | None = option(
        "--size MB", "Stop at this file size, or start a new file with --split.", type=NumberRange(min=0.001)
    )
    duration_s: float | None = option(
        "--duration TIME",
        "Stop after this time, e.g. 30, 30s, 5m or 2h, or start a new file with --split.",
        type=DURATION,
    )
    limit: int | None = option("-l --count COUNT", "Record at most COUNT messages of each topic.", type=COUNT)
    bz2: bool = flag("-j --bz2", "Compress with bz2: small, but slow (a few MB per second).")
    lz4: bool = flag("--lz4", "Compress with LZ4: fast.")
    chunk_kb: int = option(
        "--chunksize KB", "The size of a chunk, in KB (default: 768).", type=COUNT, default=768
    )
    publishes_begin: bool = flag("-p --publish", "Publish the name of each new file on /begin_write.")
    repeat_latched: bool = flag(
        "--repeat-latched", "Write the latched messages at the beginning of each file."
    )
    buffer_mb: int = option(
        "-b --buffsize MB",
        "The size of the buffer; when it is full, messages are dropped (default: 256).",
        type=click.IntRange(min=0),
        default=256,
    )
    form: str | None = shared(format_option, None)
    storage: str = shared(storage_option, "mcap")
    quiet: bool = flag("-q --quiet", "Print only errors.")
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())

    @property
    def compression(self) -> str:
        """The name of the compression of chunks."""
        if self.bz2:
            return "bz2"
        return "lz4" if self.lz4 else "none"

    @property
    def buffer_bytes(self) -> int | None:
        """The size of the buffer, None without one: without compression, messages are written immediately."""
        if self.compression == "none":
            return None
        return (self.buffer_mb or MAX_BUFFER_MB) * MEGABYTE


@verb(
    "record",
    """
    rostether bag record --all
    rostether bag record -O drive.bag /ultrasound /imu_data
    rostether bag record --all -O drive.mcap
    rostether bag record -e "/arm/.*" --split --size 500 --max-splits 4
    rostether bag record --all --exclude "/camera.*" --lz4 --duration 5m
    rostether bag record --ros2 zenoh --all
    """,
    is_service=True,
    old_options={"--output-name": "--output", "--limit": "--count"},
)
@option_group("options", RecordOptions)
@click.argument("topics", nargs=-1, metavar="[TOPIC]...", shell_complete=complete_topics)
@ignored_options(flags=["--tcpnodelay", "--udp", "--topics"])
@graph_options(allow=True, zenoh=True)
async def bag_record(options: RecordOptions, topics: tuple[str, ...], graph: GraphOptions) -> None:
    """Record topics, as raw bytes, until Ctrl-C, a limit, or a full disk.

    The file is called NAME.active until it is closed. If the command is killed, the file lacks at most the
    last half second; `rostether bag reindex` repairs it.
    """
    from rostether.recording.files import Form
    from rostether.recording.recording_plan import RecordLimits, TopicChoice

    if options.split and options.size_mb is None and options.duration_s is None:
        raise click.UsageError("--split needs --size or --duration")
    if options.bz2 and options.lz4:
        raise click.UsageError("give --bz2 or --lz4, not both")
    environment = read_environment(graph)
    # roslaunch passes remappings and private parameters among the topics.
    remapped = {
        resolve(old, environment): resolve(new, environment)
        for old, marker, new in (each.partition(":=") for each in topics)
        if marker and not old.startswith("_")
    }
    topics = tuple(each for each in topics if ":=" not in each)
    if not topics and not options.records_all and options.node is None:
        raise click.UsageError("give the topics to record, or --all")
    full_names = [] if options.has_patterns else [resolve(each, environment) for each in topics]
    choice = TopicChoice(
        names=tuple(dict.fromkeys(remapped.get(each, each) for each in full_names)),
        patterns=tuple(_pattern(each) for each in topics) if options.has_patterns else (),
        exclude=None if options.exclude is None else _pattern(options.exclude),
        is_all=options.records_all,
        node="" if options.node is None else resolve(options.node, environment),
        with_hidden=not graph.is_ros2_alone,
    )
    limits = RecordLimits(
        size_bytes=None if options.size_mb is None else round(options.size_mb * MEGABYTE),
        duration_s=options.duration_s,
        is_splitting=options.split,
        max_splits=options.max_splits,
        messages_per_topic=options.limit,
    )
    source = Form.ROS2 if graph.is_ros2_alone else Form.ROS1
    path, form = new_path(options.output_name, options.output_prefix, source, asked_form(options.form))
    check_compression(path, options.compression, options.storage)
    await _record(graph, choice, limits, path, form, options)


async def _record(
    graph_options: GraphOptions,
    choice: TopicChoice,
    limits: RecordLimits,
    path: Path,
    form: Form,
    options: RecordOptions,
) -> None:
    from rostether.recording.files import Form
    from rostether.recording.recorder import Recorder
    from rostether.recording.ros2.channels import UnfitMessages

    def report(text: str) -> None:
        if not options.quiet:
            line.clear()
            write_line(text)

    def report_unfit(text: str) -> None:
        line.clear()
        warn(text)

    unfit = UnfitMessages(report_unfit)
    line = ProgressLine(is_shown=not options.quiet and sys.stderr.isatty())
    async with recording_graph(
        graph_options, "record", is_native=form is Form.ROS2, msg_paths=options.msg_paths
    ) as graph:
        create, path_of = _files(path, form, options, graph.types, unfit)
        if options.publishes_begin:
            create = await _reporting_begin(graph.raw, create)
        recorder = Recorder(
            graph.raw,
            choice,
            limits,
            create=create,
            name=path_of,
            report=report,
            repeat_latched=options.repeat_latched,
            buffer_bytes=options.buffer_bytes,
        )
        try:
            # A signal and `rosnode kill` are the normal ends of a recording.
            with suppress(asyncio.CancelledError):
                async with task_beside(line.refresh(recorder)):
                    await run_until(recorder.run(), graph.raw.wait_closed())
        finally:
            line.clear()
            _report_result(recorder, unfit, report)


def _report_result(recorder: Recorder, unfit: UnfitMessages, report: Callable[[str], None]) -> None:
    """Report the written files, and warn about messages that are missing in them."""
    written = [str(each) for each in recorder.progress.files if each.exists()]
    if not written:
        # The error about the first file is enough.
        return
    total = counted(recorder.progress.message_count, "message")
    report(f"{total}, {size_text(recorder.size_bytes)} in {', '.join(written)}")
    for topic, count in unfit.counts.items():
        warn(f"WARNING: {topic}: {misfit_text(count)}; skipped")
    if not recorder.progress.message_count and not unfit.counts:
        warn(
            "WARNING: no messages were received; `rostether topic list -v` shows which topics have publishers"
        )


def _files(
    path: Path, form: Form, options: RecordOptions, types: Ros2Types | None, unfit: UnfitMessages
) -> tuple[Create, Callable[[int], Path]]:
    """Return a function that creates a file, and one that returns the path of a file, given its number."""
    from rostether.recording.files import FILE_SUFFIXES, create_recording

    compression, chunk_bytes = options.compression, options.chunk_kb * KILOBYTE
    if path.suffix in FILE_SUFFIXES:
        create = partial(
            create_recording,
            compression=compression,
            chunk_bytes=chunk_bytes,
            form=form,
            types=types,
            unfit=unfit,
        )
        return create, lambda number: path.with_stem(f"{path.stem}_{number}") if options.split else path
    from rostether.recording.ros2.bag_writer import Ros2Bag

    storage = options.storage
    bag = Ros2Bag(path, storage, compression=compression, chunk_bytes=chunk_bytes, types=types, unfit=unfit)
    return bag.create, bag.path_of


async def _reporting_begin(graph: Graph, create_file: Create) -> Create:
    """Return a function that creates a file and publishes its name on /begin_write."""
    from rostether.msgdef.registry import Registry
    from rostether.recording.file_lock import ACTIVE_SUFFIX

    publisher = await graph.advertise(BEGIN_TOPIC, Registry().message_type("std_msgs/String"), latch=True)

    def create(path: Path) -> RecordingWriter:
        writer = create_file(path)
        name = str(path).removesuffix(ACTIVE_SUFFIX).encode(errors="surrogateescape")
        # A std_msgs/String: the length of its text in bytes, and the text.
        publisher.publish_raw([len(name).to_bytes(4, "little") + name])
        return writer

    return create


def _pattern(text: str) -> re.Pattern[str]:
    try:
        return re.compile(text)
    except re.error as error:
        raise ConfigError(f"{text!r} is not a regular expression: {error}") from None
