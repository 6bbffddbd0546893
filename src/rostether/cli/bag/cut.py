"""`rostether bag cut`: copies a period of many recordings into one."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path

import click

from rostether.cli.bag.formatting import time_text
from rostether.cli.bag.record import DURATION
from rostether.cli.shell.option_group import PATH, add_option
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import counted, listed
from rostether.rostime import NS_PER_S

# An error that lists more topics is hard to read.
_SHOWN_TOPICS = 10


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
