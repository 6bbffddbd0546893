"""`topic echo` on a ROS 2 graph, as `ros2 topic echo` prints it."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from contextlib import aclosing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rostether.cli.access.ros2_tool_node import tool_node
from rostether.cli.access.ros_choice import Middleware
from rostether.cli.shell.output import warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.topic.ros2_chosen_topic import ChosenTopic, choose_topic
from rostether.cli.topic.ros2_message_text import MessageText, TextStyle
from rostether.errors import GraphError, SerializationError

if TYPE_CHECKING:
    from rostether.cli.access.ros2_tool_node import ToolNode

CLEAR_SCREEN = "\033[2J\033[;H"


@dataclass(frozen=True, slots=True)
class EchoOptions:
    """What the command line asks for."""

    type_name: str | None = None
    field: str = ""
    csv: bool = False
    as_json: bool = False
    clear: bool = False
    count: int | None = None
    timeout_s: float | None = None
    filter: Callable[[object, str], bool] | None = None
    style: TextStyle | None = None


def echo(middleware: Middleware, topic: str, options: EchoOptions, msg_paths: tuple[Path, ...]) -> None:
    """Print messages until there are enough. Raises GraphError, ConfigError, UnknownTypeError."""
    run(_echo(middleware, topic, options, msg_paths))


async def _echo(
    middleware: Middleware, topic: str, options: EchoOptions, msg_paths: tuple[Path, ...]
) -> None:
    async with tool_node(middleware, msg_paths) as tool:
        try:
            async with asyncio.timeout(options.timeout_s):
                await _print(tool, topic, options)
        except TimeoutError:
            raise GraphError(f"no message came on {topic} within {options.timeout_s:g} s") from None


async def _print(tool: ToolNode, topic: str, options: EchoOptions) -> None:
    chosen = await choose_topic(tool, topic, options.type_name, options.field)
    printer = _Printer(tool, chosen, options)
    stream = tool.graph.messages(chosen.topic, chosen.type)
    async with aclosing(aiter(stream)) as messages:
        async for message in messages:
            printer.show(message)
            if printer.is_done:
                return


class _Printer:
    """Prints messages in one style and counts them."""

    def __init__(self, tool: ToolNode, chosen: ChosenTopic, options: EchoOptions) -> None:
        self._shown_count = 0
        self._options = options
        self._chosen = chosen
        self._text = MessageText(tool.registry.ros2_message, options.style)
        self._definition = tool.registry.ros2_message(chosen.type)
        self._lookup = tool.registry.ros2_message
        self._problem = ""

    @property
    def is_done(self) -> bool:
        """Whether as many messages as wanted have been printed."""
        return self._options.count is not None and self._shown_count >= self._options.count

    def show(self, message: Any) -> None:
        """Print a message that the filter lets through."""
        options, field = self._options, self._chosen.field
        if options.filter is not None and not options.filter(message, self._chosen.topic):
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
            write_line(f"{self._text.python_value(value, self._chosen.field.type)}\n---")
        else:
            field = self._chosen.field
            definition = self._definition if field is None else self._lookup(field.type.base)
            if self._options.csv:
                write_line(self._text.csv(value, definition))
            else:
                write_line(f"{self._text.yaml(value, definition)}---")
