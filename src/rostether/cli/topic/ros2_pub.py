"""`topic pub` on a ROS 2 graph, as `ros2 topic pub` does it."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rostether.cli.access.ros2_tool_node import tool_node
from rostether.cli.access.ros_choice import Middleware
from rostether.cli.shell.output import write_line
from rostether.cli.shell.running import run
from rostether.cli.topic.ros2_message_text import MessageText, TextStyle
from rostether.cli.topic.ros2_typed_values import ValueForm
from rostether.errors import GraphError
from rostether.ros2.native_registry import short_name
from rostether.rostime import Time

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedPublisher

DEFAULT_RATE_HZ = 1.0
WAIT_LINE_S = 1.0
MATCH_POLL_S = 0.02
KEEP_ALIVE_S = 0.1
"""As ros2: what a message needs to reach the wire before the publisher goes."""


@dataclass(frozen=True, slots=True)
class PubOptions:
    """What the command line asks for; `times` 0 is without end, `print_nth` 0 prints nothing."""

    rate_hz: float = DEFAULT_RATE_HZ
    times: int = 0
    print_nth: int = 1
    wait_for: int | None = None
    max_wait_s: float | None = None
    keep_alive_s: float = KEEP_ALIVE_S
    latch: bool = False
    documents: str | None = None


def pub(
    middleware: Middleware,
    topic: str,
    type_name: str,
    arguments: tuple[str, ...],
    options: PubOptions,
    msg_paths: tuple[Path, ...],
) -> None:
    """Publish. Raises UnknownTypeError, SerializationError naming the field, GraphError."""
    run(_pub(middleware, topic, type_name, arguments, options, msg_paths))


async def _pub(
    middleware: Middleware,
    topic: str,
    type_name: str,
    arguments: tuple[str, ...],
    options: PubOptions,
    msg_paths: tuple[Path, ...],
) -> None:
    from rostether.serde.yaml_form import load_arguments, load_documents

    # Mistakes are told before anybody is asked to subscribe.
    values = [load_arguments(arguments)]
    if options.documents is not None:
        values = list(load_documents(options.documents))
    name = short_name(type_name)
    async with tool_node(middleware, msg_paths) as tool:
        form = ValueForm(tool.registry.ros2_message, lambda: Time.from_ns(time.time_ns()))
        codec, definition = tool.graph.store.codec(name), tool.registry.ros2_message(name)
        messages = [form.fill(codec, definition, each) for each in values]
        text = MessageText(tool.registry.ros2_message, TextStyle(truncate_length=None))
        publisher = await tool.graph.publisher(topic, name, latch=options.latch)
        await _wait_for_subscribers(publisher, options)
        write_line("publisher: beginning loop")
        due_s = time.monotonic()
        count = 0
        leaving = asyncio.ensure_future(tool.graph.raw.wait_closed())
        while not leaving.done():
            # `now` and `auto` are the time of each message.
            given = values[count % len(values)]
            message: Any = form.fill(codec, definition, given) if count else messages[0]
            count += 1
            if options.print_nth and count % options.print_nth == 0:
                write_line(f"publishing #{count}: {text.python(message, definition)}\n")
            publisher.publish(message)
            if options.times and count >= options.times:
                break
            due_s = max(due_s + 1 / options.rate_hz, time.monotonic() - 1 / options.rate_hz)
            await asyncio.wait({leaving}, timeout=max(due_s - time.monotonic(), 0.0))
        await publisher.drained(options.keep_alive_s)
        await asyncio.sleep(options.keep_alive_s)


async def _wait_for_subscribers(publisher: TypedPublisher, options: PubOptions) -> None:
    wanted = options.wait_for
    if wanted is None:
        wanted = 1 if options.times else 0
    begin_s = said_s = time.monotonic()
    while publisher.subscriber_count < wanted:
        now_s = time.monotonic()
        if options.max_wait_s is not None and now_s - begin_s > options.max_wait_s:
            raise GraphError(
                f"nobody subscribed to {publisher.topic} within {options.max_wait_s:g} s; -w 0 does not wait"
            )
        if now_s >= said_s:
            write_line(f"Waiting for at least {wanted} matching subscription(s)...")
            said_s = now_s + WAIT_LINE_S
        await asyncio.sleep(MATCH_POLL_S)
