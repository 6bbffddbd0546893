"""`rostether topic` on a ROS 2 graph."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.options import refuse_ros1_only
from rostether.cli.access.ros2_tool_node import tool_node
from rostether.cli.shell.output import paint_keys, write_line
from rostether.cli.topic.echo_printer import EchoPrinter
from rostether.cli.topic.misfit_notice import shown_messages
from rostether.cli.topic.options import EchoOptions, PubOptions
from rostether.cli.topic.ros2_chosen_topic import ChosenRos2Topic, choose_ros2_topic
from rostether.cli.topic.ros2_listing import Ros2TopicListing
from rostether.errors import GraphError
from rostether.graph.ros_clock import wall_time
from rostether.mechanisms.text import counted
from rostether.ros2.types.message_text import DEFAULT_TRUNCATE_LENGTH, MessageText, TextStyle
from rostether.ros2.types.native_registry import short_name

if TYPE_CHECKING:
    from rostether.cli.access.ros2_tool_node import ToolNode
    from rostether.graph.typed_handles import TypedPublisher

# As in `ros2 topic pub`: the rate without -r, and the interval of the lines about missing subscribers.
DEFAULT_RATE_HZ = 1.0
WAIT_LINE_S = 1.0
# The number of subscribers is in memory, and a message should not be noticeably later than its subscriber.
MATCH_POLL_S = 0.02
# As in `ros2 topic pub`: the time to send the last message before the publisher ends.
KEEP_ALIVE_S = 0.1
# A subscriber on a busy machine may take seconds to discover the publisher; the limit is for one that hangs.
ACKNOWLEDGE_S = 10.0


class Ros2Topics(Ros2TopicListing):
    """The topics of a ROS 2 graph; each method is a whole command."""

    async def echo(self, topic: str, type_name: str | None, options: EchoOptions) -> None:
        """Print messages as `ros2 topic echo` does."""
        refuse_ros1_only(plot=options.plot, number_width=options.number_width, offset=options.offset)
        # A wrong filter is reported before the node subscribes.
        options.compiled_filter()
        count = 0
        async with tool_node(self._graph, options.msg_paths) as tool:
            try:
                async with asyncio.timeout(options.timeout_s):
                    chosen = await choose_ros2_topic(tool, topic, type_name, options.field)
                    printer = _Printer(tool, chosen, options)
                    async with shown_messages(tool.graph.messages(chosen.topic, chosen.type)) as messages:
                        async for message in messages:
                            printer.print_message(message)
                            count = printer.shown_count
                            if printer.is_done:
                                return
            except TimeoutError:
                if count and options.wanted_count is None:
                    return
                kind = "message" if options.expression is None else "matching message"
                wanted = counted(options.wanted_count or 0, kind)
                what = f"only {count} of {wanted}" if count else f"no {kind}"
                raise GraphError(
                    f"{what} arrived on {topic} within {options.timeout_s:g} s; "
                    f"`rostether topic info {topic}` shows its publishers"
                ) from None

    async def publish(
        self, topic: str, type_name: str, values: tuple[str, ...], file_text: str | None, options: PubOptions
    ) -> None:
        """Publish messages as `ros2 topic pub` does."""
        from rostether.serde.yaml_form import fill_or_default, load_arguments, load_documents

        refuse_ros1_only(substitute_keywords=options.substitute_keywords, use_rostime=options.use_rostime)
        if options.once and options.times:
            raise click.UsageError("give one of -1 and -t, not both")
        # Errors are reported before anything is advertised.
        given = [load_arguments(values)]
        if file_text is not None:
            given = list(load_documents(file_text))
        name = short_name(type_name)
        async with tool_node(self._graph, options.msg_paths) as tool:
            codec, definition = tool.graph.store.codec(name), tool.registry.ros2_message(name)
            messages = [fill_or_default(codec, each, now=wall_time) for each in given]
            support = tool.types.by_name(definition.full_name)
            for checked in messages:
                # Strings or arrays that are too long raise an error here; a publisher would omit the message.
                support.converter.to_cdr(codec.encode(checked))
            text = MessageText(tool.registry.ros2_message, TextStyle(truncate_length=None))
            is_latched = options.latch or options.qos_durability == "transient_local"
            publisher = await tool.graph.publisher(topic, name, latch=is_latched)
            times = 1 if options.once else options.times
            print_nth = 1 if options.print_nth is None else options.print_nth
            period_s = 1 / (options.rate_hz or DEFAULT_RATE_HZ)
            await _wait_for_subscribers(publisher, times, options)
            write_line("publisher: beginning loop")
            due_s = time.monotonic()
            count = 0
            leaving = asyncio.ensure_future(tool.graph.raw.wait_closed())
            while not leaving.done():
                # `now` and `auto` get the time of each message.
                message: Any = messages[0]
                if count:
                    message = fill_or_default(codec, given[count % len(given)], now=wall_time)
                count += 1
                if print_nth and count % print_nth == 0:
                    write_line(f"publishing #{count}: {text.python(message, definition)}\n")
                publisher.publish(message)
                if times and count >= times:
                    break
                due_s = max(due_s + period_s, time.monotonic() - period_s)
                await asyncio.wait({leaving}, timeout=max(due_s - time.monotonic(), 0.0))
            await publisher.drained(ACKNOWLEDGE_S)
            await asyncio.sleep(KEEP_ALIVE_S)


async def _wait_for_subscribers(publisher: TypedPublisher[...], times: int, options: PubOptions) -> None:
    wanted = options.wait_for
    if wanted is None:
        wanted = 1 if times else 0
    begin_s = reported_s = time.monotonic()
    while publisher.subscriber_count < wanted:
        now_s = time.monotonic()
        if options.max_wait_s is not None and now_s - begin_s > options.max_wait_s:
            raise GraphError(
                f"{publisher.topic} has {publisher.subscriber_count} of {wanted} subscribers after "
                f"{options.max_wait_s:g} s; -w 0 publishes without waiting"
            )
        if now_s >= reported_s:
            write_line(f"Waiting for at least {wanted} matching subscription(s)...")
            reported_s = now_s + WAIT_LINE_S
        await asyncio.sleep(MATCH_POLL_S)


class _Printer(EchoPrinter):
    """Prints messages as `ros2 topic echo` does."""

    def __init__(self, tool: ToolNode, chosen: ChosenRos2Topic, options: EchoOptions) -> None:
        super().__init__(chosen.topic, options)
        self.path = chosen.path
        self._chosen = chosen
        self._lookup = tool.registry.ros2_message
        length = DEFAULT_TRUNCATE_LENGTH if options.truncate_length is None else options.truncate_length
        style = TextStyle(
            None if options.full_length else length, options.noarr, options.nostr, options.flow_style
        )
        self._text = MessageText(self._lookup, style)

    def write_text(self, value: Any) -> None:
        """Print a message or a field of it."""
        from rostether.serde.values import Message

        shown_type = self._chosen.field_type
        if not isinstance(value, Message):
            assert shown_type is not None
            write_line(f"{self._text.python_value(value, shown_type)}\n---", paint_keys)
            return
        definition = self._lookup(self._chosen.type if shown_type is None else shown_type.base)
        if self.options.csv:
            write_line(self._text.csv(value, definition))
        else:
            write_line(f"{self._text.yaml(value, definition)}---", paint_keys)
