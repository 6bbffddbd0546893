"""`topic echo` on a ROS 2 graph, as `ros2 topic echo` prints it."""

from __future__ import annotations

import asyncio
import sys
from typing import TYPE_CHECKING, Any

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros2_tool_node import tool_node
from rostether.cli.shell.output import paint_keys, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.topic.meter import shown_messages
from rostether.cli.topic.ros2_chosen_topic import ChosenTopic, choose_topic
from rostether.cli.topic.ros2_message_text import DEFAULT_TRUNCATE_LENGTH, MessageText, TextStyle
from rostether.cli.topic.topics import EchoOptions
from rostether.errors import GraphError, SerializationError

if TYPE_CHECKING:
    from rostether.cli.access.ros2_tool_node import ToolNode

CLEAR_SCREEN = "\033[2J\033[;H"


def echo(graph: GraphOptions, topic: str, type_name: str | None, options: EchoOptions) -> None:
    """Print messages until there are enough. Raises GraphError, ConfigError, UnknownTypeError."""
    # A wrong filter is reported before anything is subscribed.
    options.compiled_filter()
    run(_echo(graph, topic, type_name, options))


async def _echo(graph: GraphOptions, topic: str, type_name: str | None, options: EchoOptions) -> None:
    async with tool_node(graph, options.msg_paths) as tool:
        try:
            async with asyncio.timeout(options.timeout_s):
                await _print(tool, topic, type_name, options)
        except TimeoutError:
            raise GraphError(f"no message was received on {topic} within {options.timeout_s:g} s") from None


async def _print(tool: ToolNode, topic: str, type_name: str | None, options: EchoOptions) -> None:
    chosen = await choose_topic(tool, topic, type_name, options.field)
    printer = _Printer(tool, chosen, options)
    async with shown_messages(tool.graph.messages(chosen.topic, chosen.type)) as messages:
        async for message in messages:
            printer.show(message)
            if printer.is_done:
                return


def _style(options: EchoOptions) -> TextStyle:
    length = DEFAULT_TRUNCATE_LENGTH if options.truncate_length is None else options.truncate_length
    return TextStyle(
        None if options.full_length else length, options.noarr, options.nostr, options.flow_style
    )


class _Printer:
    """Prints messages in one style and counts them."""

    def __init__(self, tool: ToolNode, chosen: ChosenTopic, options: EchoOptions) -> None:
        self._shown_count = 0
        self._options = options
        self._filter = options.compiled_filter()
        self._chosen = chosen
        self._text = MessageText(tool.registry.ros2_message, _style(options))
        self._definition = tool.registry.ros2_message(chosen.type)
        self._lookup = tool.registry.ros2_message
        self._problem = ""

    @property
    def is_done(self) -> bool:
        """Whether as many messages as wanted have been printed."""
        return self._options.wanted_count is not None and self._shown_count >= self._options.wanted_count

    def show(self, message: Any) -> None:
        """Print a message that the filter lets through."""
        options, field = self._options, self._chosen.field
        if self._filter is not None and not self._filter(message, self._chosen.topic):
            return
        try:
            value = message if field is None else field.path.read(message)
        except SerializationError as error:
            if str(error) != self._problem:
                self._problem = str(error)
                warn(self._problem)
            return
        self._shown_count += 1
        if options.clear:
            sys.stdout.write(CLEAR_SCREEN)
        self._write(value)

    def _write(self, value: Any) -> None:
        from rostether.serde.plain_form import plain_value
        from rostether.serde.values import Message

        if self._options.as_json:
            plain = plain_value(value)
            write_json(plain if isinstance(plain, dict) else {"value": plain})
        elif not isinstance(value, Message):
            assert self._chosen.field is not None
            write_line(f"{self._text.python_value(value, self._chosen.field.type)}\n---", paint_keys)
        else:
            field = self._chosen.field
            definition = self._definition if field is None else self._lookup(field.type.base)
            if self._options.csv:
                write_line(self._text.csv(value, definition))
            else:
                write_line(f"{self._text.yaml(value, definition)}---", paint_keys)
