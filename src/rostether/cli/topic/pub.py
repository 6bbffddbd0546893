"""`rostether topic pub`: publishing messages typed on the command line, from a file or through a pipe."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.completions import complete_message_types, complete_topics
from rostether.cli.access.options import master_option, msg_path_option, tool_allow_option
from rostether.cli.access.refusals import refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import qos_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.input_files import read_text
from rostether.cli.shell.output import write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import ConfigError, DefinitionError, TypeMismatchError
from rostether.msgdef.interface import ANY_TYPE
from rostether.rostime import Time

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph, TypedPublisher
    from rostether.serde.codec import Codec
    from rostether.serde.values import Message

ONCE_S = 3.0
"""How long `-1` stays: subscribers that find us take a moment, rostopic gives them this long."""

FILE_RATE_HZ = 10.0
"""For messages from files and pipes, as rostopic."""

SUBSCRIBER_TIMEOUT_S = 5.0
"""Messages from files and pipes wait this long for somebody who listens."""


@dataclass(frozen=True, slots=True)
class _Options:
    rate_hz: float | None
    once: bool
    latch: bool
    verbose: bool
    substitute: bool
    use_rostime: bool
    text: str | None


@click.command(
    "pub",
    cls=Verb,
    examples="""
    rostether topic pub -1 /toggle_led std_msgs/Empty
    rostether topic pub -r 10 /cmd_vel geometry_msgs/Twist "{linear: {x: 0.2}}"
    rostether topic pub -1 /servo std_msgs/UInt16 90
    rostether topic pub -r 1 -s /a geometry_msgs/PointStamped "{header: auto}"
    """,
)
@click.argument("topic", shell_complete=complete_topics)
@click.argument("type_name", metavar="TYPE", shell_complete=complete_message_types)
@click.argument("arguments", nargs=-1, metavar="[VALUES]...")
@click.option("-1", "--once", is_flag=True, help="Publish one message, let it arrive and end.")
@click.option("-r", "--rate", "rate_hz", type=click.FloatRange(min=0, min_open=True), metavar="HZ")
@click.option(
    "-l", "--latch", is_flag=True, help="Latch with -r, -f and pipes too; a lone message always is."
)
@click.option("-f", "--file", type=click.Path(path_type=Path), help="Take the messages of a YAML file.")
@click.option(
    "-s", "--substitute-keywords", is_flag=True, help="With -r, fill `now` and `auto` in each time."
)
@click.option("--use-rostime", is_flag=True, help="Stamp with ROS time, not with this machine's clock.")
@click.option("-v", "verbose", is_flag=True, help="Show what is published.")
@click.option(
    "-t",
    "--times",
    type=click.IntRange(min=0),
    default=0,
    metavar="COUNT",
    help="With --ros2, end after COUNT messages.",
)
@click.option(
    "-w",
    "--wait-matching-subscriptions",
    "wait_for",
    type=click.IntRange(min=0),
    metavar="COUNT",
    help="With --ros2, begin when COUNT subscribers are there (1 with -1 and -t, else 0).",
)
@click.option(
    "--max-wait-time-secs",
    "max_wait_s",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="With --ros2, give up waiting for subscribers.",
)
@click.option(
    "-p",
    "--print",
    "print_nth",
    type=click.IntRange(min=0),
    metavar="N",
    help="With --ros2, show every N-th message only.",
)
@click.option(
    "--qos-durability",
    type=click.Choice(["volatile", "transient_local", "system_default"]),
    metavar="DURABILITY",
    help="With --ros2, transient_local is the same as -l.",
)
@msg_path_option
@master_option
@tool_allow_option
@ros1_option
@ros2_option
@qos_habits
def pub(
    topic: str,
    type_name: str,
    arguments: tuple[str, ...],
    once: bool,
    rate_hz: float | None,
    latch: bool,
    file: Path | None,
    substitute_keywords: bool,
    use_rostime: bool,
    verbose: bool,
    times: int,
    wait_for: int | None,
    max_wait_s: float | None,
    print_nth: int | None,
    qos_durability: str | None,
    msg_paths: tuple[Path, ...],
    master: str | None,
) -> None:
    """Publish messages.

    VALUES are YAML: one mapping of the message's fields, the rest being zero, or the value of each field in
    order; write -- before a negative number. `now` is a time, `auto` a header that is stamped now. Without
    -1 and -r the message is latched until Ctrl-C. Without VALUES, messages come from a file (-f) or a pipe,
    in YAML documents separated by ---.

    With --ros2 it is as `ros2 topic pub`: without -1 and -t it publishes again and again, once a second
    unless -r says otherwise, and fields that are not given have their defaults.
    """
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.topic import ros2_pub as ros2

        refuse_ros1_only(substitute_keywords=substitute_keywords, use_rostime=use_rostime, master=master)
        if once and times:
            raise click.UsageError("give one of -1 and -t, not both")
        options2 = ros2.PubOptions(
            rate_hz or ros2.DEFAULT_RATE_HZ,
            1 if once else times,
            1 if print_nth is None else print_nth,
            wait_for,
            max_wait_s,
            latch=latch or qos_durability == "transient_local",
            documents=_read(file, arguments),
        )
        ros2.pub(middleware, topic, type_name, arguments, options2, msg_paths)
        return
    refuse_ros2_only(
        times=times,
        wait_for=wait_for is not None,
        max_wait_s=max_wait_s,
        print_nth=print_nth is not None,
        qos_durability=qos_durability,
    )
    if once and rate_hz is not None:
        raise click.UsageError("give one of -1 and -r, not both")
    text = _read(file, arguments)
    options = _Options(rate_hz, once, latch, verbose, substitute_keywords, use_rostime, text)
    run(_pub(topic, type_name, arguments, options, msg_paths, master))


def _read(file: Path | None, arguments: tuple[str, ...]) -> str | None:
    if arguments and file is not None:
        raise click.UsageError("give values or a file, not both")
    return read_text(file) if file is not None else None


async def _pub(
    topic: str,
    type_name: str,
    arguments: tuple[str, ...],
    options: _Options,
    msg_paths: tuple[Path, ...],
    master: str | None,
) -> None:
    from rostether.cli.access.ros1_access import joined, read_environment, resolve
    from rostether.msgdef.registry import Registry
    from rostether.serde.store import TypeStore
    from rostether.serde.yaml_form import fill_message, load_arguments

    environment = read_environment(master)
    name = resolve(topic, environment)
    store = TypeStore(Registry.from_environment(msg_paths))
    codec = store.codec(type_name)
    values = load_arguments(arguments)
    is_typed = bool(arguments) or not codec.message_class._fields
    # Mistakes are told before anybody is asked to subscribe.
    if is_typed:
        fill_message(codec, values, now=_wall_time)
    elif options.text is None and sys.stdin.isatty():
        fields = " ".join(field for field, _ in codec.message_class._fields)
        raise click.UsageError(f"{type_name} wants values: {fields}")
    async with joined(environment, store=store, purpose="rostopic") as graph:
        await _check_type(graph, name, codec)
        now = graph.now if options.use_rostime else _wall_time
        is_latched = options.rate_hz is None or options.latch
        publisher = await graph.publisher(name, type_name, latch=is_latched)
        output = _Output(publisher, graph.raw.wait_closed, options)
        if not is_typed:
            await output.publish_documents(_documents(codec, options.text, now))
        elif options.rate_hz is None:
            await output.publish_latched(fill_message(codec, values, now=now))
        else:
            first = fill_message(codec, values, now=now)
            again = options.substitute
            await output.repeat(
                (lambda: fill_message(codec, values, now=now)) if again else lambda: first, options.rate_hz
            )


async def _check_type(graph: TypedGraph, topic: str, codec: Codec) -> None:
    """Refuse a type that the topic does not have: nobody would get the message."""
    known = (await graph.snapshot()).topics.get(topic)
    if known is None or known.type in (ANY_TYPE, codec.type_name):
        return
    registry = graph.store.registry
    try:
        # tf/tfMessage and tf2_msgs/TFMessage are one type under two names.
        if registry.message_type(known.type).md5sum == registry.message_type(codec.type_name).md5sum:
            return
    except DefinitionError:
        pass
    raise TypeMismatchError(
        f"{topic} is {known.type}, not {codec.type_name}; publish that type, or on another topic"
    )


class _Output:
    """Publishes in the ways that the options ask for, until the node is told to leave."""

    def __init__(self, publisher: TypedPublisher, wait_closed: Callable[[], Any], options: _Options) -> None:
        self._publisher = publisher
        self._leaving = asyncio.ensure_future(wait_closed())
        self._options = options

    async def publish_latched(self, message: Message) -> None:
        """Publish one message and keep it there: for 3 seconds with -1, else until told to end."""
        what = f"message [{_shown(message)}]" if self._options.verbose else "message"
        end = f" for {ONCE_S} seconds" if self._options.once else ". Press ctrl-C to terminate"
        write_line(f"publishing and latching {what}{end}")
        self._publisher.publish(message)
        await self._sleep(ONCE_S if self._options.once else None)

    async def repeat(self, make: Callable[[], Message], rate_hz: float) -> None:
        """Publish at a rate until told to end."""
        due_s = time.monotonic()
        while not self._leaving.done():
            self._publish(make())
            due_s = max(due_s + 1 / rate_hz, time.monotonic() - 1 / rate_hz)
            await self._sleep(max(due_s - time.monotonic(), 0.0))

    async def publish_documents(self, messages: AsyncIterator[Message]) -> None:
        """Publish what a file or pipe holds; a file's only message again and again."""
        options = self._options
        rate_hz = options.rate_hz or (None if options.once or options.latch else FILE_RATE_HZ)
        await self._publisher.wait_for_subscriber(SUBSCRIBER_TIMEOUT_S)
        first = await anext(messages, None)
        if first is None:
            raise ConfigError("there was no message to publish: YAML documents are separated by ---")
        if rate_hz is None:
            await self.publish_latched(first)
            return
        second = await anext(messages, None)
        if second is None and options.text is not None:
            write_line("Got one message and a rate, publishing repeatedly")
            await self.repeat(lambda: first, rate_hz)
            return
        self._publish(first)
        await self._sleep(1 / rate_hz)
        if second is not None:
            self._publish(second)
            await self._sleep(1 / rate_hz)
        async for message in messages:
            self._publish(message)
            await self._sleep(1 / rate_hz)
            if self._leaving.done():
                break

    def _publish(self, message: Message) -> None:
        if self._options.verbose:
            write_line(f"publishing {_shown(message)}")
        self._publisher.publish(message)

    async def _sleep(self, duration_s: float | None) -> None:
        await asyncio.wait({self._leaving}, timeout=duration_s)


def _shown(message: Message) -> str:
    from rostether.serde.yaml_print import format_message

    return format_message(message)


def _wall_time() -> Time:
    return Time.from_ns(time.time_ns())


async def _documents(codec: Codec, text: str | None, now: Callable[[], Time]) -> AsyncIterator[Message]:
    from rostether.cli.shell.piped_documents import piped_documents
    from rostether.serde.yaml_form import parse_documents

    if text is not None:
        for message in parse_documents(codec, text, now=now):
            yield message
        return
    async for document in piped_documents(sys.stdin):
        for message in parse_documents(codec, document, now=now):
            yield message
