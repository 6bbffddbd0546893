"""What hz, bw and delay share: waiting for topics, listening to them, and a report every second."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from contextlib import aclosing, asynccontextmanager
from pathlib import Path
from typing import Any

from rostether.cli.access.ros1_access import joined, read_environment, resolve
from rostether.cli.access.ros_choice import chosen_ros2
from rostether.cli.shell.output import warn, write_line
from rostether.cli.topic.chosen_topic import wait_for_topic
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.interface import ANY_MESSAGE

REPORT_PERIOD_S = 1.0


class TopicMeter:
    """Listens to topics while reports are made; `names` are the topics' full names."""

    def __init__(
        self, graph: TypedGraph, names: Sequence[str], quiet: bool, word: str = "subscribed"
    ) -> None:
        self.graph = graph
        self.names = names
        self._quiet = quiet
        self._word = word
        self.encoders: dict[str, Callable[[bytes], bytes]] = {}
        """What makes of a topic's messages what is sent, where that is something else."""
        self._listening: set[asyncio.Task[None]] = set()

    async def take_raw(self, name: str, add: Callable[[Sequence[bytes]], None]) -> None:
        """Hand every chunk of undecoded messages to `add`."""
        await self.graph.raw.subscribe(name, ANY_MESSAGE, add)
        self._tell(name)

    def size_bytes(self, name: str, payload: bytes) -> int:
        """Return how long a message of a topic is on its way."""
        encode = self.encoders.get(name)
        return len(payload if encode is None else encode(payload))

    def take(self, name: str, add: Callable[[Any], None]) -> None:
        """Hand every decoded message to `add`; what it raises ends the reports."""

        async def listen() -> None:
            async with aclosing(aiter(self.graph.messages(name))) as messages:
                async for message in messages:
                    add(message)

        self._listening.add(asyncio.get_running_loop().create_task(listen()))
        self._tell(name)

    async def reports(self, count: int | None) -> AsyncIterator[None]:
        """Yield once a second, `count` times or until the node leaves. Raises what `add` raised."""
        leaving = asyncio.ensure_future(self.graph.raw.wait_closed())
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        made = 0
        try:
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
        finally:
            leaving.cancel()

    async def close(self) -> None:
        """Stop listening."""
        for task in self._listening:
            task.cancel()
        await asyncio.gather(*self._listening, return_exceptions=True)

    def _tell(self, name: str) -> None:
        if not self._quiet:
            write_line(f"{self._word} to [{name}]")


@asynccontextmanager
async def meter(
    topics: Iterable[str], msg_paths: Iterable[Path], master: str | None, *, quiet: bool
) -> AsyncIterator[TopicMeter]:
    """Join the graph and wait for the topics; `quiet` leaves the lines out that say so."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.access.ros2_tool_node import tool_node
        from rostether.cli.topic.ros2_chosen_topic import choose_topic

        async with tool_node(middleware, msg_paths) as tool:
            chosen_topics = [await choose_topic(tool, topic) for topic in topics]
            found = TopicMeter(tool.graph, [each.topic for each in chosen_topics], quiet, "Subscribed")
            for each in chosen_topics:
                support = tool.types.message(tool.registry.message_type(each.type))
                found.encoders[each.topic] = support.converter.to_cdr
            try:
                yield found
            finally:
                await found.close()
        return
    environment = read_environment(master)
    async with joined(environment, msg_paths, purpose="rostopic") as graph:
        names = []
        for topic in topics:
            chosen = await wait_for_topic(resolve(topic, environment), graph.store, master)
            names.append(chosen.topic)
        if not quiet and await graph.get_param("/use_sim_time", False):
            warn("WARNING: may be using simulated time")
        found = TopicMeter(graph, names, quiet)
        try:
            yield found
        finally:
            await found.close()
