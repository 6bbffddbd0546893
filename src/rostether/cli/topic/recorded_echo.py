"""`topic echo -b` and `topic list -b`: the messages and topics of a recording, as rostopic prints them."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import click

from rostether.cli.bag.recording_files import warn_of_damage
from rostether.cli.shell.output import write_line
from rostether.cli.topic.options import EchoOptions, with_field
from rostether.cli.topic.ros1_echo import Ros1Printer
from rostether.errors import ConfigError
from rostether.mechanisms.text import did_you_mean
from rostether.recording.decoding import Decoder
from rostether.recording.files import open_recording
from rostether.rostime import Time


def echo_recording(path: Path, topic: str | None, options: EchoOptions) -> None:
    """Print the messages of a topic, or of all topics. Raises RecordingError, ConfigError."""
    if options.offset:
        raise click.UsageError("--offset does not work with a recording; omit it")
    options.refuse_ros2_only()
    decoder = Decoder()
    with closing(open_recording(path)) as reader:
        warn_of_damage(path, reader)
        topics = sorted({each.topic for each in reader.counts})
        chosen, field = (None, "") if topic is None else _split(with_field(topic, options), topics, path)
        printers: dict[str, Ros1Printer] = {}
        for message in reader.messages(lambda each: chosen in (None, each.topic)):
            name = message.connection.topic
            now = Time.from_ns(message.time_ns)
            printer = printers.setdefault(name, Ros1Printer(name, field, options))
            printer.show(decoder.decode(message), decoder.codec(message.connection), now)
            shown = sum(each.shown_count for each in printers.values())
            if options.wanted_count is not None and shown >= options.wanted_count:
                break


def list_recording(path: Path) -> None:
    """Print the topics. Raises RecordingError."""
    with closing(open_recording(path)) as reader:
        for topic in sorted({each.topic for each in reader.counts}):
            write_line(topic)


def _split(text: str, topics: list[str], path: Path) -> tuple[str, str]:
    """Return the topic that a text starts with, and the field after it."""
    name = text if text.startswith("/") else f"/{text}"
    for topic in sorted(topics, key=len, reverse=True):
        if name == topic or name.startswith((f"{topic}/", f"{topic}[")):
            return topic, name[len(topic) :].removeprefix("/")
    hint = did_you_mean(name, topics) or f"it has {', '.join(topics) or 'no topics'}"
    raise ConfigError(f"{path} has no topic {name}; {hint}")
