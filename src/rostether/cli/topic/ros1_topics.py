"""`rostether topic` on a ROS 1 graph."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from typing import TYPE_CHECKING

import click

from rostether.cli.access.options import refuse_ros2_only
from rostether.cli.access.ros1_access import joined, resolve, type_store
from rostether.cli.shell.output import warn, write_line
from rostether.cli.topic.options import EchoOptions, PubOptions, with_field
from rostether.cli.topic.ros1_listing import Ros1TopicListing
from rostether.errors import ConfigError, DefinitionError, TypeMismatchError
from rostether.graph.ros_clock import wall_time
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.interface import ANY_TYPE
from rostether.rostime import Time

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.graph.typed_handles import TypedPublisher
    from rostether.serde.codec import Codec
    from rostether.serde.values import Message

# How long `-1` runs, as in rostopic: subscribers need a moment to connect.
ONCE_S = 3.0
# The rate of messages from files and pipes, like rostopic's.
FILE_RATE_HZ = 10.0
# Every graph has these topics, so a similar name is not a typing error.
LOG_TOPICS = ("/rosout", "/rosout_agg")
# Messages from files and pipes wait this long for a subscriber: latching keeps only the last one.
SUBSCRIBER_TIMEOUT_S = 5.0


class Ros1Topics(Ros1TopicListing):
    """The topics of a ROS 1 graph; each method is a whole command."""

    async def echo(self, topic: str, type_name: str | None, options: EchoOptions) -> None:
        """Print messages as rostopic does."""
        from rostether.cli.topic.ros1_echo import echo

        refuse_ros2_only(type_name=type_name)
        options.refuse_ros2_only()
        # A wrong filter is reported before the node subscribes.
        options.compiled_filter()
        await echo(self._graph, with_field(topic, options), options)

    async def publish(
        self, topic: str, type_name: str, values: tuple[str, ...], file_text: str | None, options: PubOptions
    ) -> None:
        """Publish messages as rostopic does."""
        from rostether.msgdef.search_waiting import wait_for_definitions
        from rostether.serde.yaml_form import fill_message, load_arguments

        refuse_ros2_only(
            times=options.times,
            wait_for=options.wait_for is not None,
            max_wait_s=options.max_wait_s,
            print_nth=options.print_nth is not None,
            qos_durability=options.qos_durability,
        )
        if options.once and options.rate_hz is not None:
            raise click.UsageError("give one of -1 and -r, not both")
        name = resolve(topic, self._environment)
        store = type_store(options.msg_paths)
        await wait_for_definitions(store.registry, lambda: store.registry.message_type(type_name))
        codec = store.codec(type_name)
        given = load_arguments(values)
        is_typed = bool(values) or not codec.message_class._fields
        # Errors are reported before anything is advertised.
        if is_typed:
            fill_message(codec, given, now=wall_time)
        elif file_text is None and sys.stdin.isatty():
            fields = " ".join(field for field, _ in codec.message_class._fields)
            raise click.UsageError(f"{type_name} needs values: {fields}; {{}} sets all to zero")
        async with joined(self._graph, store=store, purpose="rostopic") as graph:
            await _check_type(graph, name, codec)
            now = graph.now if options.use_rostime else wall_time
            is_latched = options.rate_hz is None or options.latch
            publisher = await graph.publisher(name, type_name, latch=is_latched)
            async with task_beside(graph.raw.wait_closed()) as leaving:
                output = _Output(publisher, leaving, options)
                if not is_typed:
                    await output.publish_documents(_documents(codec, file_text, now))
                    return
                first = fill_message(codec, given, now=now)
                if options.rate_hz is None:
                    await output.publish_latched(first)
                elif options.substitute_keywords:
                    await output.repeat(lambda: fill_message(codec, given, now=now), options.rate_hz)
                else:
                    await output.repeat(lambda: first, options.rate_hz)


async def _check_type(graph: TypedGraph, topic: str, codec: Codec) -> None:
    """Warn about a name that may be mistyped. Raises TypeMismatchError if the topic has another type.

    No subscriber would get messages of another type.
    """
    topics = (await graph.snapshot()).topics
    known = topics.get(topic)
    subscribed = (name for name in topics if topics[name].subscribers and name not in LOG_TOPICS)
    if known is None and (hint := did_you_mean(topic, subscribed)):
        warn(f"WARNING: no node subscribes to {topic}; {hint}")
    if known is None or known.type in (ANY_TYPE, codec.type_name):
        return
    registry = graph.store.registry
    with suppress(DefinitionError):
        # tf/tfMessage and tf2_msgs/TFMessage are one type under two names.
        if registry.message_type(known.type).md5sum == registry.message_type(codec.type_name).md5sum:
            return
    raise TypeMismatchError(
        f"{topic} has the type {known.type}, not {codec.type_name}; publish this type, or use another topic"
    )


class _Output:
    """Publishes as the options demand, until the node is shut down."""

    def __init__(
        self, publisher: TypedPublisher[...], leaving: asyncio.Task[object], options: PubOptions
    ) -> None:
        self._publisher = publisher
        self._leaving = leaving
        self._options = options
        self._sequence = 0

    async def publish_latched(self, message: Message) -> None:
        """Publish one latched message, for 3 seconds with -1, else until the node is shut down."""
        what = f"message [{_shown(message)}]" if self._options.verbose else "message"
        end = f" for {ONCE_S} seconds" if self._options.once else ". Press ctrl-C to terminate"
        write_line(f"publishing and latching {what}{end}")
        self._send(message)
        await self._sleep(ONCE_S if self._options.once else None)

    async def repeat(self, make: Callable[[], Message], rate_hz: float) -> None:
        """Publish what `make` returns at a rate, until the node is shut down."""
        due_s = time.monotonic()
        while not self._leaving.done():
            self._publish(make())
            due_s = max(due_s + 1 / rate_hz, time.monotonic() - 1 / rate_hz)
            await self._sleep(max(due_s - time.monotonic(), 0.0))

    async def publish_documents(self, messages: AsyncIterator[Message]) -> None:
        """Publish the messages of a file or pipe; the only message of a file is published repeatedly.

        Raises ConfigError without a message.
        """
        options = self._options
        rate_hz = options.rate_hz or (None if options.once or options.latch else FILE_RATE_HZ)
        await self._publisher.wait_for_subscriber(SUBSCRIBER_TIMEOUT_S)
        first = await anext(messages, None)
        if first is None:
            raise ConfigError(
                "no message to publish; give VALUES, or YAML documents separated by --- in a file or pipe"
            )
        if rate_hz is None:
            await self.publish_latched(first)
            return
        begin = [first]
        if options.file is not None:
            second = await anext(messages, None)
            if second is None:
                write_line("Got one message and a rate, publishing repeatedly")
                await self.repeat(lambda: first, rate_hz)
                return
            begin.append(second)
        for message in begin:
            await self._publish_and_sleep(message, 1 / rate_hz)
        async for message in messages:
            if self._leaving.done():
                return
            await self._publish_and_sleep(message, 1 / rate_hz)

    async def _publish_and_sleep(self, message: Message, duration_s: float) -> None:
        self._publish(message)
        await self._sleep(duration_s)

    def _publish(self, message: Message) -> None:
        if self._options.verbose:
            write_line(f"publishing {_shown(message)}")
        self._send(message)

    def _send(self, message: Message) -> None:
        """Publish a message with the topic's own count as Header.seq, as in rostopic."""
        from rostether.serde.csv_print import has_header

        self._sequence += 1
        if has_header(message):
            message.header.seq = self._sequence & 0xFFFFFFFF
        self._publisher.publish(message)

    async def _sleep(self, duration_s: float | None) -> None:
        await asyncio.wait({self._leaving}, timeout=duration_s)


def _shown(message: Message) -> str:
    from rostether.serde.yaml_print import format_message

    return format_message(message)


async def _documents(codec: Codec, text: str | None, now: Callable[[], Time]) -> AsyncIterator[Message]:
    from rostether.cli.shell.input import piped_documents
    from rostether.serde.yaml_form import parse_documents

    if text is not None:
        for message in parse_documents(codec, text, now=now):
            yield message
        return
    async for document in piped_documents(sys.stdin):
        for message in parse_documents(codec, document, now=now):
            yield message
