"""The common part of hz, bw and delay: they wait for topics, subscribe to them, and report every second."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from contextlib import AbstractAsyncContextManager, aclosing, asynccontextmanager
from pathlib import Path
from typing import Any

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import joined, read_environment, resolve
from rostether.cli.shell.output import warn, write_line
from rostether.cli.topic.misfit_notice import shown_messages
from rostether.cli.topic.ros1_chosen_topic import wait_for_topic
from rostether.errors import ConfigError, UnknownTypeError
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.tasks import cancel_all
from rostether.msgdef.interface import ANY_MESSAGE

# As in rostopic and ros2 topic.
REPORT_PERIOD_S = 1.0


class TopicMeter:
    """Listens to topics while reports are made; `names` are the topics' full names."""

    def __init__(
        self, graph: TypedGraph, names: Sequence[str], quiet: bool, *, is_ros2: bool = False
    ) -> None:
        self.graph = graph
        self.names = names
        self._quiet = quiet
        self.is_ros2 = is_ros2
        # By topic: the function that converts a message's ROS 1 bytes to those on the wire.
        self.encoders: dict[str, Callable[[bytes], bytes]] = {}
        self._listening: set[asyncio.Task[None]] = set()

    async def add_raw_listener(self, name: str, add: Callable[[Sequence[bytes]], None]) -> None:
        """Call `add` with every chunk of undecoded messages."""
        await self.graph.raw.subscribe(name, ANY_MESSAGE, add)
        self._report(name)

    def stamp_s(self, name: str, message: Any) -> float:
        """Return the time in a message's header in seconds. Raises ConfigError without a header."""
        if "header" not in type(message).__slots__:
            raise ConfigError(
                f"{name} has no header, so the age of its messages is unknown; choose a topic with a header"
            )
        stamp = message.header.stamp
        return stamp.sec + stamp.nanosec * 1e-9 if self.is_ros2 else float(stamp.to_s())

    def size_bytes(self, name: str, payload: bytes) -> int:
        """Return the size of a topic's message on the wire."""
        encode = self.encoders.get(name)
        return len(payload if encode is None else encode(payload))

    def add_listener(self, name: str, add: Callable[[Any], None]) -> None:
        """Call `add` with every decoded message; an exception from it ends the reports."""

        async def listen() -> None:
            async with shown_messages(self.graph.messages(name)) as messages:
                async for message in messages:
                    add(message)

        self._listening.add(asyncio.get_running_loop().create_task(listen()))
        self._report(name)

    async def reports(self, count: int | None) -> AsyncIterator[None]:
        """Yield once a second, `count` times or until the node leaves. Raises the error of `add`."""
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        made = 0
        async with task_beside(self.graph.raw.wait_closed()) as leaving:
            while not leaving.done() and made != count:
                due_s += REPORT_PERIOD_S
                timeout_s = max(due_s - loop.time(), 0.0)
                waited = {leaving, *self._listening}
                done, _ = await asyncio.wait(waited, timeout=timeout_s, return_when=asyncio.FIRST_COMPLETED)
                for task in done - {leaving}:
                    await task
                if not done:
                    made += 1
                    yield

    async def aclose(self) -> None:
        """Stop listening."""
        await cancel_all(*self._listening)

    def _report(self, name: str) -> None:
        if not self._quiet:
            write_line(f"{'Subscribed' if self.is_ros2 else 'subscribed'} to [{name}]")


def topic_meter(
    graph: GraphOptions,
    topics: Iterable[str],
    msg_paths: Iterable[Path] = (),
    *,
    quiet: bool,
    needs_definitions: bool,
) -> AbstractAsyncContextManager[TopicMeter]:
    """Join the graph and wait for the topics; `quiet` omits the progress lines.

    Without `needs_definitions`, a meter of ROS 2 only gets undecoded messages. Raises ConfigError,
    InvalidNameError, GraphError, DefinitionError.
    """
    if graph.ros2 is None:
        return _ros1_meter(graph, topics, msg_paths, quiet=quiet)
    return _ros2_meter(graph, topics, msg_paths, quiet=quiet, needs_definitions=needs_definitions)


@asynccontextmanager
async def _ros1_meter(
    graph: GraphOptions, topics: Iterable[str], msg_paths: Iterable[Path], *, quiet: bool
) -> AsyncIterator[TopicMeter]:
    environment = read_environment(graph)
    async with joined(graph, msg_paths, purpose="rostopic") as node:
        names = []
        for topic in topics:
            chosen = await wait_for_topic(resolve(topic, environment), node, environment)
            names.append(chosen.topic)
        if not quiet and await node.get_param("/use_sim_time", False):
            warn("WARNING: may be using simulated time")
        async with aclosing(TopicMeter(node, names, quiet)) as meter:
            yield meter


@asynccontextmanager
async def _ros2_meter(
    graph: GraphOptions,
    topics: Iterable[str],
    msg_paths: Iterable[Path],
    *,
    quiet: bool,
    needs_definitions: bool,
) -> AsyncIterator[TopicMeter]:
    from rostether.cli.access.ros2_tool_node import tool_node
    from rostether.cli.topic.ros2_chosen_topic import choose_ros2_topic

    async with tool_node(graph, msg_paths, needs_definitions=needs_definitions) as tool:
        chosen_topics = [
            await choose_ros2_topic(tool, topic, needs_definition=needs_definitions) for topic in topics
        ]
        meter = TopicMeter(tool.graph, [each.topic for each in chosen_topics], quiet, is_ros2=True)
        for each in chosen_topics:
            try:
                support = tool.types.message(tool.registry.message_type(each.type))
            except UnknownTypeError:
                if needs_definitions:
                    raise
                continue
            meter.encoders[each.topic] = support.converter.to_cdr
        async with aclosing(meter):
            yield meter
