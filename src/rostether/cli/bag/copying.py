"""`rostether bag convert`, `filter` and `cut`: copy messages to a new recording."""

from __future__ import annotations

import re
from contextlib import closing
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.bag.formatting import time_text
from rostether.cli.bag.recording_files import (
    asked_form,
    format_option,
    open_for,
    recording_types,
    storage_option,
    warn_of_damage,
)
from rostether.cli.shell.interrupts import cleaning_up
from rostether.cli.shell.option_group import DURATION, PATH, add_option
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import counted, listed, misfit_text
from rostether.rostime import NS_PER_S, Time

if TYPE_CHECKING:
    from rostether.recording.recorded import RecordedMessage

_NAMES = frozenset(("topic", "m", "t"))
_MESSAGE = re.compile(r"\bm\b")
# An error that lists more topics is hard to read.
_SHOWN_TOPICS = 10


@verb(
    "convert",
    """
    rostether bag convert drive.bag drive.mcap
    rostether bag convert drive.mcap drive.bag
    rostether bag convert drive.bag smaller.bag --compression bz2
    rostether bag convert drive.bag drive             a ROS 2 bag, a folder
    rostether bag convert rosbag2_2026_11_20 drive.bag
    """,
)
@click.argument("source", type=PATH)
@click.argument("target", type=PATH)
@add_option(
    "--compression",
    "The compression of chunks (default: none).",
    type=click.Choice(["none", "bz2", "lz4"]),
    default="none",
)
@format_option
@storage_option
@msg_path_option
@cleaning_up()
def bag_convert(
    source: Path, target: Path, compression: str, form: str | None, storage: str, msg_paths: tuple[Path, ...]
) -> None:
    """Write the messages of SOURCE to TARGET, with their times, topics and types.

    The extensions .bag, .mcap and .db3 select the format; a name without one of them is a ROS 2 bag, a
    folder. Messages are copied byte for byte, and converted only between ROS 1 and ROS 2.
    """
    from rostether.recording.files import Form
    from rostether.recording.reindexing import copy, refuse_same

    refuse_same(source, target)
    reader, target_form = open_for(source, target, asked_form(form))
    with closing(reader):
        warn_of_damage(source, reader.damage)
        # Only types that go from ROS 1 to ROS 2 must be known; the recordings contain all others.
        types = recording_types((), msg_paths) if msg_paths and target_form is Form.ROS2 else None
        count = copy(reader, target, compression=compression, form=target_form, storage=storage, types=types)
        unfit = sum(reader.counts.values()) - count
        if unfit and not reader.unreadable:
            warn(f"{source}: {misfit_text(unfit)}; `rostether bag check` shows which")
        for topic, why in reader.unreadable.items():
            warn(f"{source}: {topic} is not copied completely: {why}")
    write_line(f"{target}: {counted(count, 'message')}")


@verb(
    "filter",
    """
    rostether bag filter drive.bag arm.bag "topic.startswith('/arm/')"
    rostether bag filter drive.bag near.bag "topic == '/ultrasound' and m.range < 0.5"
    rostether bag filter drive.bag start.bag "t.to_sec() < 1700000060"
    """,
)
@click.argument("source", type=PATH)
@click.argument("target", type=PATH)
@click.argument("expression")
@add_option("-p --print shown EXPRESSION", "Also print this expression for each message.")
@cleaning_up()
def bag_filter(source: Path, target: Path, expression: str, shown: str | None) -> None:
    """Write the messages of SOURCE for which EXPRESSION is true to TARGET, with their times.

    EXPRESSION is Python. It can use `topic`, the message `m` with its fields, and the time `t` with `secs`
    and `nsecs`.
    """
    from rostether.expression.compiler import compile_expression
    from rostether.recording.decoding import Decoder
    from rostether.recording.files import create_recording
    from rostether.recording.reindexing import refuse_same, write_messages

    refuse_same(source, target)
    test = compile_expression(expression, _NAMES, source="EXPRESSION")
    show = None if shown is None else compile_expression(shown, _NAMES, source="--print")
    needs_message = _MESSAGE.search(f"{expression} {shown}") is not None
    decoder = Decoder()
    total = 0

    def is_wanted(message: RecordedMessage) -> bool:
        nonlocal total
        total += 1
        value = decoder.decode(message) if needs_message else None
        topic = message.connection.topic
        scope = {"topic": topic, "t": Time.from_ns(message.time_ns), "m": value}
        try:
            matches = bool(test(scope))
            line = None if show is None else show(scope)
        except ConfigError as error:
            raise ConfigError(
                f"{topic}: {error}; to filter one topic only, write: topic == '/NAME' and ..."
            ) from None
        if show is not None:
            write_line(f"{'MATCH' if matches else 'NO MATCH'} {line}")
        return matches

    reader, form = open_for(source, target)
    with closing(reader):
        warn_of_damage(source, reader.damage)
        messages = filter(is_wanted, reader.messages())
        count = write_messages(messages, target, partial(create_recording, form=form))
    write_line(f"{target}: {count} of {counted(total, 'message')}")


@verb(
    "cut",
    """
    rostether bag cut recordings -o seen.bag --from 14:02
    rostether bag cut recordings -o seen.bag --from 14:02:30 --duration 10s --topic "/sensors/Robot3/*"
    rostether bag cut monday.bag tuesday.bag -o night.bag --from 23:55 --duration 10m
    """,
)
@click.argument("sources", nargs=-1, required=True, type=PATH, metavar="RECORDING...")
@add_option("-o --output target FILE", "The .bag, .mcap or .db3 file, or folder.", required=True, type=PATH)
@add_option(
    "--from start TIME",
    "The local time, e.g. 14:02, 14:02:30 or 2026-11-23 14:02; without a date, the latest one recorded; "
    "+01:00 or Z after it names the time zone.",
    required=True,
)
@add_option(
    "--duration TIME",
    "The length of the period, e.g. 30, 30s, 5m or 2h (default: 1m).",
    type=DURATION,
    default=60.0,
)
@add_option("-t --topic topics TOPIC", "Only this topic; * matches anything.", multiple=True)
@cleaning_up()
def bag_cut(
    sources: tuple[Path, ...], target: Path, start: str, duration: float, topics: tuple[str, ...]
) -> None:
    """Write the messages of a period to a new recording.

    A RECORDING is a file, a ROS 2 bag, a folder of recordings, or a folder of such folders. Files that
    are still being recorded are also read.
    """
    from rostether.recording.cutting import Cutting, find_recordings, moment_ns, second_moment

    cutting = Cutting(find_recordings(sources))
    for why in cutting.unreadable.values():
        warn(f"skipped: {why}")
    for path, damage in cutting.damage.items():
        warn_of_damage(path, damage)
    first_ns, last_ns = cutting.span_ns
    start_ns = moment_ns(start, last_ns)
    if second := second_moment(start, start_ns):
        warn(f"this time occurs twice, because clocks were set back; the second time is {second}")

    def is_chosen(topic: str) -> bool:
        return not topics or any(fnmatchcase(topic, each) for each in topics)

    if not any(map(is_chosen, cutting.topics)):
        known = listed(sorted(cutting.topics), _SHOWN_TOPICS)
        raise ConfigError(f"no recorded topic is {' or '.join(topics)}; recorded: {known}")
    count, recordings = cutting.write(
        target, lambda each: is_chosen(each.topic), start_ns, start_ns + int(duration * NS_PER_S)
    )
    if not count:
        raise ConfigError(
            f"nothing was recorded at {time_text(start_ns)}; the recordings reach from {time_text(first_ns)} "
            f"to {time_text(last_ns)}"
        )
    write_line(
        f"{target}: {counted(count, 'message')} from {counted(recordings, 'recording')}, "
        f"from {time_text(start_ns)}"
    )
