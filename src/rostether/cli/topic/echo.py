"""`rostether topic echo`: a topic's messages, or one field of them, as rostopic prints them."""

from __future__ import annotations

import asyncio
import contextlib
import sys
from collections.abc import Callable
from contextlib import aclosing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.completions import complete_topics
from rostether.cli.access.options import master_option, msg_path_option, tool_allow_option
from rostether.cli.access.refusals import refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import qos_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import GraphError, SerializationError

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.rostime import Time
    from rostether.serde.codec import Codec
    from rostether.serde.field_path import FieldPath

CLEAR_SCREEN = "\033[2J\033[;H"

SILENCE_WARNING_S = 2.0
"""As rostopic for simulators, which publish at once: then it says what may be missing."""


@dataclass(frozen=True, slots=True)
class _Options:
    """What the command line asks for."""

    plot: bool
    as_json: bool
    clear: bool
    count: int | None
    filter: Callable[[object, str], bool] | None
    no_arrays: bool
    no_strings: bool
    number_width: int | None
    offset: bool


@click.command(
    "echo",
    cls=Verb,
    examples="""
    rostether topic echo /ultrasound
    rostether topic echo -n 1 /ultrasound/range
    rostether topic echo --filter "m.range < 0.5" /ultrasound
    rostether topic echo -p /imu_data/angular_velocity > turning.csv
    """,
)
@click.argument("topic", metavar="TOPIC[/FIELD]", shell_complete=complete_topics)
@click.argument("type_name", metavar="[TYPE]", required=False)
@click.option("-n", "count", type=click.IntRange(min=1), metavar="COUNT", help="End after COUNT messages.")
@click.option("--once", is_flag=True, help="End after one message.")
@click.option("-p", "plot", is_flag=True, help="Print comma-separated values, for plotting.")
@json_option
@click.option("-c", "--clear", is_flag=True, help="Clear the screen before each message.")
@click.option("--noarr", "--no-arr", is_flag=True, help="Leave arrays out.")
@click.option("--nostr", "--no-str", is_flag=True, help="Leave strings out.")
@click.option("-w", "number_width", type=click.IntRange(min=2), metavar="WIDTH", help="Columns of a number.")
@click.option("--offset", is_flag=True, help="Print times relative to now, in seconds.")
@click.option(
    "--filter",
    "expression",
    metavar="EXPRESSION",
    help="Print only messages m for which the Python expression is true.",
)
@click.option("--field", default="", metavar="FIELD", help="With --ros2, print one field, as header.stamp.")
@click.option("--csv", is_flag=True, help="With --ros2, print all values in a line, with commas between.")
@click.option("-f", "--full-length", is_flag=True, help="With --ros2, cut nothing.")
@click.option(
    "-l",
    "--truncate-length",
    type=click.IntRange(min=0),
    metavar="LENGTH",
    help="With --ros2, cut arrays and texts after LENGTH (128).",
)
@click.option("--flow-style", is_flag=True, help="With --ros2, print each message on one line.")
@click.option(
    "--timeout",
    "timeout_s",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="With --ros2, give up after SECONDS.",
)
@msg_path_option
@master_option
@tool_allow_option
@ros1_option
@ros2_option
@click.option("--qos-durability", expose_value=False, hidden=True)
@qos_habits
def echo(
    topic: str,
    type_name: str | None,
    count: int | None,
    once: bool,
    plot: bool,
    as_json: bool,
    clear: bool,
    noarr: bool,
    nostr: bool,
    number_width: int | None,
    offset: bool,
    expression: str | None,
    field: str,
    csv: bool,
    full_length: bool,
    truncate_length: int | None,
    flow_style: bool,
    timeout_s: float | None,
    msg_paths: tuple[Path, ...],
    master: str | None,
) -> None:
    """Print the messages of a topic, or a field of them.

    The types of messages are learned from their publisher, so even types that are not installed here can
    be shown. A topic that is not there yet is waited for, unless its TYPE is given.
    """
    count = 1 if once else count
    test = None
    if expression is not None:
        from rostether.expression.compiler import compile_filter

        test = compile_filter(expression)
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.topic import ros2_echo as ros2
        from rostether.cli.topic.ros2_message_text import DEFAULT_TRUNCATE_LENGTH, TextStyle

        refuse_ros1_only(plot=plot, number_width=number_width, offset=offset, master=master)
        limit = DEFAULT_TRUNCATE_LENGTH if truncate_length is None else truncate_length
        style = TextStyle(None if full_length else limit, noarr, nostr, flow_style)
        options2 = ros2.EchoOptions(
            type_name, field, csv, as_json, clear, count, timeout_s, test, style=style
        )
        ros2.echo(middleware, topic, options2, msg_paths)
        return
    refuse_ros2_only(
        type_name=type_name,
        field=field,
        csv=csv,
        full_length=full_length,
        truncate_length=truncate_length,
        flow_style=flow_style,
        timeout_s=timeout_s,
    )
    options = _Options(plot, as_json, clear, count, test, noarr, nostr, number_width, offset)
    run(_echo(topic, options, msg_paths, master))


async def _echo(topic: str, options: _Options, msg_paths: tuple[Path, ...], master: str | None) -> None:
    from rostether.cli.access.ros1_access import joined, read_environment
    from rostether.cli.topic.chosen_topic import resolve_with_field, wait_for_topic

    environment = read_environment(master)
    name = resolve_with_field(topic, environment)
    async with joined(environment, msg_paths, purpose="rostopic") as graph:
        chosen = await wait_for_topic(name, graph.store, master)
        printer = _Printer(graph, chosen.topic, chosen.field, options)
        hint = asyncio.ensure_future(_hint_at_silence(graph, chosen.topic, printer))
        try:
            stream = graph.messages(chosen.topic)
            async with aclosing(aiter(stream)) as messages:
                async for message in messages:
                    assert stream.codec is not None
                    printer.show(message, stream.codec)
                    if printer.is_done:
                        break
        finally:
            hint.cancel()


class _Printer:
    """Prints messages in one style and counts them."""

    def __init__(self, graph: TypedGraph, topic: str, field: str, options: _Options) -> None:
        self.received_count = 0
        self._shown_count = 0
        self._graph = graph
        self._topic = topic
        self._field = field
        self._options = options
        self._codec: Codec | None = None
        self._path: FieldPath | None = None
        self._problem = ""

    @property
    def is_done(self) -> bool:
        """Whether as many messages as wanted have been printed."""
        return self._options.count is not None and self._shown_count >= self._options.count

    def show(self, message: Any, codec: Codec) -> None:
        """Print a message that the filter lets through. Raises ConfigError for a field its type lacks."""
        self.received_count += 1
        options = self._options
        if options.filter is not None and not options.filter(message, self._topic):
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
        write_line(f"{text}\n---")

    def _now_if_offset(self) -> Time | None:
        return self._graph.now() if self._options.offset else None

    def _style(self, time_offset: Time | None) -> Any:
        from rostether.serde.yaml_print import EchoStyle

        options = self._options
        return EchoStyle(
            no_arrays=options.no_arrays,
            no_strings=options.no_strings,
            time_offset=time_offset,
            number_width=options.number_width,
        )


async def _hint_at_silence(graph: TypedGraph, topic: str, printer: _Printer) -> None:
    # A master that is away is told of elsewhere.
    with contextlib.suppress(GraphError):
        is_simulated = await graph.get_param("/use_sim_time", False)
        await asyncio.sleep(SILENCE_WARNING_S)
        if printer.received_count:
            return
        known = (await graph.snapshot()).topics.get(topic)
        if is_simulated:
            warn("WARNING: no messages received and simulated time is active.\nIs /clock being published?")
        elif known is None or not known.publishers:
            warn(f"WARNING: nobody publishes [{topic}] yet")
