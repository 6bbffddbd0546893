"""A relay between two graphs: chosen topics and services of each are in the other too.

A topic is carried to the other graph as long as somebody besides the relay publishes it, in both directions
at once where both are chosen: the relay's subscribers leave out what the relay itself publishes, so that
nothing comes back. A service is offered in the graph that does not have it as long as the other one has it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from rostether.errors import GraphError, RostetherError
from rostether.graph.ports import Level, Snapshot
from rostether.relay.choice import Choice, Direction
from rostether.relay.service_relay import ServiceRelay
from rostether.relay.side import Side
from rostether.relay.topic_relay import TopicRelay

RETRY_S = 2.0
"""How soon what a graph refused is tried again, as long as it is wanted; graphs come back within seconds."""

Report = Callable[[Level, str], None]


class _Wish(NamedTuple):
    """Something to be carried; `chosen_type` is that of a service, empty where the graph tells it."""

    is_service: bool
    name: str
    source: Side
    target: Side
    chosen_type: str = ""

    @property
    def text(self) -> str:
        kind = "service " if self.is_service else ""
        return f"{kind}{self.name} from {self.source.name} to {self.target.name}"


class Relay:
    """Carries what is chosen between two sides; `report` gets a line for each beginning, end and trouble."""

    def __init__(self, first: Side, second: Side, choice: Choice, report: Report) -> None:
        self._sides = (first, second)
        self._choice = choice
        self._report = report
        self._seen: dict[str, Snapshot] = {}
        self._news = asyncio.Event()
        self._carrying: dict[_Wish, asyncio.Task[None]] = {}
        self._ending: dict[_Wish, asyncio.Task[None]] = {}
        self._relays: dict[_Wish, TopicRelay | ServiceRelay] = {}

    @property
    def relays(self) -> list[TopicRelay | ServiceRelay]:
        """What is carried now, or waits for a publisher."""
        return list(self._relays.values())

    async def run(self) -> None:
        """Carry until cancelled. Raises GraphError when a graph tells the relay's node to leave."""
        watching = [asyncio.ensure_future(self._follow(side)) for side in self._sides]
        leaving = [asyncio.ensure_future(self._leave(side)) for side in self._sides]
        arranging = asyncio.ensure_future(self._arrange_always())
        try:
            done, _ = await asyncio.wait((*leaving, arranging), return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                await task
        finally:
            tasks = [*watching, *leaving, arranging, *self._carrying.values(), *self._ending.values()]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _leave(self, side: Side) -> None:
        reason = await side.graph.wait_closed()
        raise GraphError(f"the relay's node has left {side.name}: {reason}")

    async def _follow(self, side: Side) -> None:
        while True:
            try:
                async for snapshot in side.graph.changes():
                    self._seen[side.name] = snapshot
                    self._news.set()
            except GraphError as error:
                self._report(Level.WARN, f"{side.name} cannot be seen: {error}; looking again")
            # What is carried goes on: a graph that nobody sees for a moment may work all the same.
            await asyncio.sleep(RETRY_S)

    async def _arrange_always(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            if len(self._seen) == len(self._sides):
                self._arrange(set(self._wishes()))

    def _arrange(self, wishes: set[_Wish]) -> None:
        for wish in self._carrying.keys() - wishes:
            task = self._ending[wish] = self._carrying.pop(wish)
            task.add_done_callback(partial(self._forget, wish))
            task.cancel()
        # What is wanted again while it is ending begins again at its end.
        for wish in sorted(wishes - self._carrying.keys() - self._ending.keys(), key=lambda each: each.text):
            self._carrying[wish] = asyncio.get_running_loop().create_task(self._carry(wish))

    def _forget(self, wish: _Wish, _: object) -> None:
        del self._ending[wish]
        self._news.set()

    def _wishes(self) -> Iterator[_Wish]:
        first, second = self._sides
        yield from self._topics(first, second, Direction.FORTH)
        yield from self._topics(second, first, Direction.BACK)
        yield from self._services(first, second)
        yield from self._services(second, first)

    def _topics(self, source: Side, target: Side, direction: Direction) -> Iterator[_Wish]:
        for name, topic in self._seen[source.name].topics.items():
            is_published = set(topic.publishers) - {source.graph.node_name}
            if is_published and self._choice.carries_topic(name, direction):
                yield _Wish(False, name, source, target)

    def _services(self, source: Side, target: Side) -> Iterator[_Wish]:
        there = self._seen[target.name].services
        for name, service in self._seen[source.name].services.items():
            chosen = self._choice.service(name)
            if chosen is None or not set(service.providers) - {source.graph.node_name}:
                continue
            # Of a service that both graphs have, each keeps its own.
            if name not in there or not set(there[name].providers) - {target.graph.node_name}:
                yield _Wish(True, name, source, target, chosen.type)

    async def _carry(self, wish: _Wish) -> None:
        told = ""
        while True:
            relay = self._relays[wish] = (
                ServiceRelay(wish.name, wish.source, wish.target, wish.chosen_type)
                if wish.is_service
                else TopicRelay(wish.name, wish.source, wish.target)
            )
            is_open = False
            try:
                await relay.open()
                assert relay.type is not None
                is_open = True
                self._report(Level.INFO, f"relaying {wish.text} ({relay.type.name})")
                await asyncio.Event().wait()
            except RostetherError as error:
                if str(error) != told:
                    told = str(error)
                    self._report(Level.ERROR, f"cannot relay {wish.text}: {error}")
            finally:
                del self._relays[wish]
                await self._end(relay, wish, was_open=is_open)
            await asyncio.sleep(RETRY_S)

    async def _end(self, relay: TopicRelay | ServiceRelay, wish: _Wish, *, was_open: bool) -> None:
        try:
            await relay.close()
        except RostetherError as error:
            self._report(Level.WARN, f"{wish.text} may still be listed: {error}")
        if was_open:
            self._report(Level.INFO, f"no longer relaying {wish.text}")
