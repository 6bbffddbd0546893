"""`topic echo` on a ROS 1 graph, as rostopic prints it."""

from __future__ import annotations

import asyncio
import contextlib
import sys
from typing import TYPE_CHECKING, Any

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import joined, read_environment
from rostether.cli.shell.output import paint_keys, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.topic.misfit_notice import shown_messages
from rostether.cli.topic.ros1_chosen_topic import resolve_with_field, wait_for_topic
from rostether.cli.topic.topics import EchoOptions
from rostether.errors import GraphError, SerializationError

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.rostime import Time
    from rostether.serde.codec import Codec
    from rostether.serde.field_path import FieldPath

CLEAR_SCREEN = "\033[2J\033[;H"

# As long as rostopic waits: a simulator publishes at once.
SILENCE_WARNING_S = 2.0


def echo(graph: GraphOptions, topic: str, options: EchoOptions) -> None:
    """Print messages until there are enough. Raises GraphError, ConfigError, UnknownTypeError."""
    # A wrong filter is reported before anything is subscribed.
    options.compiled_filter()
    run(_echo(graph, topic, options))


async def _echo(graph_options: GraphOptions, topic: str, options: EchoOptions) -> None:
    environment = read_environment(graph_options)
    name = resolve_with_field(topic, environment)
    async with joined(graph_options, options.msg_paths, purpose="rostopic") as graph:
        chosen = await wait_for_topic(name, graph, environment)
        printer = _Printer(graph, chosen.topic, chosen.field, options)
        hint = asyncio.ensure_future(_hint_at_silence(graph, chosen.topic, printer))
        try:
            stream = graph.messages(chosen.topic)
            async with shown_messages(stream) as messages:
                async for message in messages:
                    assert stream.codec is not None
                    printer.show(message, stream.codec)
                    if printer.is_done:
                        break
        finally:
            hint.cancel()


class _Printer:
    """Prints messages in one style and counts them."""

    def __init__(self, graph: TypedGraph, topic: str, field: str, options: EchoOptions) -> None:
        self.received_count = 0
        self._shown_count = 0
        self._graph = graph
        self._topic = topic
        self._field = field
        self._options = options
        self._filter = options.compiled_filter()
        self._codec: Codec | None = None
        self._path: FieldPath | None = None
        self._problem = ""

    @property
    def is_done(self) -> bool:
        """Whether as many messages as wanted have been printed."""
        return self._options.wanted_count is not None and self._shown_count >= self._options.wanted_count

    def show(self, message: Any, codec: Codec) -> None:
        """Print a message that the filter lets through. Raises ConfigError for a field its type lacks."""
        self.received_count += 1
        options = self._options
        if self._filter is not None and not self._filter(message, self._topic):
            return
        if self._field and codec is not self._codec:
            from rostether.serde.field_path import FieldPath

            self._codec, self._path = codec, FieldPath(codec, self._field)
        try:
            value = message if self._path is None else self._path.read(message)
        except SerializationError as error:
            if str(error) != self._problem:
                self._problem = str(error)
                warn(self._problem)
            return
        self._shown_count += 1
        if options.as_json:
            self._write_json(value)
        elif options.plot:
            self._write_row(value)
        else:
            self._write_text(value)

    def _write_json(self, value: Any) -> None:
        from rostether.serde.plain_form import plain_value

        plain = plain_value(value)
        write_json(plain if isinstance(plain, dict) else {"value": plain})

    def _write_row(self, value: Any) -> None:
        from rostether.serde.csv_print import csv_header, csv_row

        style = self._style(self._now_if_offset())
        if self._shown_count == 1:
            write_line(csv_header(value, style))
        write_line(csv_row(value, self._graph.now(), style))

    def _write_text(self, value: Any) -> None:
        from rostether.serde.yaml_print import format_message, format_value

        style = self._style(self._now_if_offset())
        text = (
            format_message(value, style)
            if self._path is None
            else format_value(value, self._path.type, style)
        )
        if self._options.clear:
            sys.stdout.write(CLEAR_SCREEN)
        write_line(f"{text}\n---", paint_keys)

    def _now_if_offset(self) -> Time | None:
        return self._graph.now() if self._options.offset else None

    def _style(self, time_offset: Time | None) -> Any:
        from rostether.serde.yaml_print import EchoStyle

        options = self._options
        return EchoStyle(
            no_arrays=options.noarr,
            no_strings=options.nostr,
            time_offset=time_offset,
            number_width=options.number_width,
        )


async def _hint_at_silence(graph: TypedGraph, topic: str, printer: _Printer) -> None:
    # Another part reports a master that is away.
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
