"""`rostether bag filter` and `cut`: copy the messages that match an expression, or those of a time."""

from __future__ import annotations

import re
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.bag.figures import time_text
from rostether.cli.bag.record import DURATION
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import Verb
from rostether.errors import ConfigError
from rostether.rostime import NS_PER_S, Time

if TYPE_CHECKING:
    from rostether.recording.recorded import Connection, RecordedMessage

_NAMES = frozenset(("topic", "m", "t"))
_MESSAGE = re.compile(r"\bm\b")


@click.command(
    "filter",
    cls=Verb,
    examples="""
    rostether bag filter drive.bag arm.bag "topic.startswith('/arm/')"
    rostether bag filter drive.bag near.bag "topic == '/ultrasound' and m.range < 0.5"
    rostether bag filter drive.bag start.bag "t.to_s() < 1700000060"
    """,
)
@click.argument("source", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path))
@click.argument("expression")
@click.option(
    "-p", "--print", "shown", metavar="EXPRESSION", help="Also print this expression for each message."
)
def bag_filter(source: Path, target: Path, expression: str, shown: str | None) -> None:
    """Write the messages of SOURCE for which EXPRESSION is true to TARGET, with their times.

    EXPRESSION is Python. It can use `topic`, the message `m` with its fields, and the time `t` with `secs`
    and `nsecs`.
    """
    from rostether.expression.compiler import compile_expression
    from rostether.recording.decoding import Decoder
    from rostether.recording.files import Form, create_recording, form_for, form_of, open_recording
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

    reader = open_recording(source)
    try:
        form = form_for(target, form_of(reader))
        if form is Form.ROS2 and form_of(reader) is Form.ROS2:
            # Messages are then values of ROS 2, with its names of fields.
            reader.close()
            reader = open_recording(source, is_native=True)
        messages = filter(is_wanted, reader.messages())
        count = write_messages(messages, target, partial(create_recording, form=form))
    finally:
        reader.close()
    write_line(f"{target}: {count} of {total} messages")


@click.command(
    "cut",
    cls=Verb,
    examples="""
    rostether bag cut recordings -o seen.bag --from 14:02
    rostether bag cut recordings -o seen.bag --from 14:02:30 --duration 10s --topic "/sensors/Robot3/*"
    rostether bag cut monday.bag tuesday.bag -o night.bag --from 23:55 --duration 10m
    """,
)
@click.argument("sources", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="RECORDING...")
@click.option(
    "-o",
    "--output",
    "target",
    required=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="The .bag, .mcap or .db3 file, or folder.",
)
@click.option(
    "--from",
    "start",
    required=True,
    metavar="TIME",
    help="The local time, e.g. 14:02, 14:02:30 or 2026-11-23 14:02; without a date, the last one recorded.",
)
@click.option(
    "--duration", type=DURATION, default=60.0, metavar="TIME", help="How much, e.g. 30, 30s, 5m or 2h (1m)."
)
@click.option(
    "-t", "--topic", "topics", multiple=True, metavar="TOPIC", help="Only this topic; * matches anything."
)
def bag_cut(
    sources: tuple[Path, ...], target: Path, start: str, duration: float, topics: tuple[str, ...]
) -> None:
    """Write what was recorded at a time to a new recording.

    A RECORDING is a file, a ROS 2 bag, or a folder of them; a file that is being recorded works too.
    """
    from rostether.recording.cutting import Cutting, find_recordings, moment_ns

    cutting = Cutting(find_recordings(sources))
    for why in cutting.unreadable.values():
        warn(f"left out: {why}")
    first_ns, last_ns = cutting.span_ns
    start_ns = moment_ns(start, last_ns)

    def is_wanted(connection: Connection) -> bool:
        return not topics or any(fnmatchcase(connection.topic, each) for each in topics)

    count, recordings = cutting.write(target, is_wanted, start_ns, start_ns + int(duration * NS_PER_S))
    if not count:
        raise ConfigError(
            f"nothing was recorded at {time_text(start_ns)}; the recordings reach from {time_text(first_ns)} "
            f"to {time_text(last_ns)}"
        )
    write_line(f"{target}: {count} messages from {recordings} recordings, from {time_text(start_ns)}")
