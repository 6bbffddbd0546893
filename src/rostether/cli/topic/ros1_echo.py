"""`topic echo` on a ROS 1 graph or of a recording, as rostopic prints it, and `topic list` of a recording."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import joined, read_environment
from rostether.cli.shell.output import paint_keys, warn, write_line
from rostether.cli.topic.echo_printer import EchoPrinter
from rostether.cli.topic.misfit_notice import shown_messages
from rostether.cli.topic.options import EchoOptions, with_field
from rostether.cli.topic.ros1_chosen_topic import resolve_with_field, wait_for_topic
from rostether.errors import ConfigError, GraphError
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.text import did_you_mean
from rostether.rostime import Time

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.serde.codec import Codec

# As in rostopic. A simulator publishes immediately.
SILENCE_WARNING_S = 2.0


async def echo(graph_options: GraphOptions, topic: str, options: EchoOptions) -> None:
    """Print messages until there are enough.

    Raises GraphError, ConfigError, InvalidNameError, UnknownTypeError.
    """
    environment = read_environment(graph_options)
    name = resolve_with_field(topic, environment)
    async with joined(graph_options, options.msg_paths, purpose="rostopic") as graph:
        chosen = await wait_for_topic(name, graph, environment)
        printer = Ros1Printer(chosen.topic, chosen.field, options)
        stream = graph.messages(chosen.topic)
        async with (
            task_beside(_hint_at_silence(graph, chosen.topic, printer)),
            shown_messages(stream) as messages,
        ):
            async for message in messages:
                assert stream.codec is not None
                printer.show(message, stream.codec, graph.now())
                if printer.is_done:
                    break


class Ros1Printer(EchoPrinter):
    """Prints messages as rostopic does."""

    def __init__(self, topic: str, field: str, options: EchoOptions) -> None:
        super().__init__(topic, options)
        self._now = Time()
        self._field = field
        self._codec: Codec | None = None

    def show(self, message: Any, codec: Codec, now: Time) -> None:
        """Print a message, unless the filter omits it. Raises ConfigError for a field that its type lacks."""
        self._now = now
        if self._field and codec is not self._codec:
            from rostether.serde.field_path import FieldPath

            self._codec, self.path = codec, FieldPath(codec, self._field)
        self.print_message(message)

    def write_text(self, value: Any) -> None:
        """Print a message or a field of it."""
        style = self._style(self._now if self.options.offset else None)
        if self.options.plot:
            from rostether.serde.csv_print import csv_header, csv_row

            if self.shown_count == 1:
                write_line(csv_header(value, style))
            # For a recording, rostopic prints the time in the file.
            write_line(csv_row(value, self._now, style, uses_stamp=self.options.bag is None))
            return
        from rostether.serde.yaml_print import format_message, format_value

        if self.path is None:
            text = format_message(value, style)
        else:
            text = format_value(value, self.path.type, style)
        write_line(f"{text}\n---", paint_keys)

    def _style(self, time_offset: Time | None) -> Any:
        from rostether.serde.yaml_print import EchoStyle

        options = self.options
        return EchoStyle(
            no_arrays=options.noarr,
            no_strings=options.nostr,
            time_offset=time_offset,
            number_width=options.number_width,
        )


async def _hint_at_silence(graph: TypedGraph, topic: str, printer: Ros1Printer) -> None:
    # The node itself reports an unreachable master.
    with contextlib.suppress(GraphError):
        is_simulated = await graph.get_param("/use_sim_time", False)
        await asyncio.sleep(SILENCE_WARNING_S)
        if printer.received_count:
            return
        known = (await graph.snapshot()).topics.get(topic)
        if is_simulated:
            warn("WARNING: no messages received and simulated time is active.\nIs /clock being published?")
        elif known is None or not known.publishers:
            warn(f"WARNING: topic [{topic}] has no publisher yet")


def echo_recording(path: Path, topic: str | None, options: EchoOptions) -> None:
    """Print the messages of a topic, or of all topics. Raises RecordingError, ConfigError."""
    if options.offset:
        raise click.UsageError("--offset does not work with a recording; omit it")
    options.refuse_ros2_only()
    from rostether.cli.bag.recording_files import warn_of_damage
    from rostether.recording.decoding import Decoder
    from rostether.recording.files import open_recording

    decoder = Decoder()
    with contextlib.closing(open_recording(path)) as reader:
        warn_of_damage(path, reader.damage)
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
    """Print the topics. Raises RecordingError, and ConfigError if an extra is missing."""
    from rostether.recording.files import open_recording

    with contextlib.closing(open_recording(path)) as reader:
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
