"""`rostether bag filter`: copies the messages for which an expression is true."""

from __future__ import annotations

import re
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.bag.recording_files import open_for
from rostether.cli.shell.option_group import PATH, add_option
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import counted
from rostether.rostime import Time

if TYPE_CHECKING:
    from rostether.recording.recorded import RecordedMessage

_NAMES = frozenset(("topic", "m", "t"))
_MESSAGE = re.compile(r"\bm\b")


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
        messages = filter(is_wanted, reader.messages())
        count = write_messages(messages, target, partial(create_recording, form=form))
    write_line(f"{target}: {count} of {counted(total, 'message')}")
