"""A relay between two graphs: offers chosen topics, services and actions of each graph in the other one.

A topic is relayed as long as a node other than the relay publishes it. If both directions are chosen, both
are active at the same time. No message comes back, because the relay's subscribers omit the messages that the
relay itself publishes. A service is offered in the graph that does not have it, while the other has it.

Nodes that are in both graphs (`graph.joint_marks`) are skipped. These are boards, which need no relay, and
other relays, whose messages are those of the other graph. If there are several relays, the first one that
relays a topic or service continues to do so. If two start at the same time, the younger one waits.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Iterator
from functools import partial

from rostether.errors import GraphError, RostetherError
from rostether.graph.joint_marks import (
    MARK_TYPE,
    MarkedNodes,
    is_mark,
    new_relay_mark,
    relay_marks,
    replace_names,
)
from rostether.graph.ports import Level, Publisher, Report, Snapshot
from rostether.mechanisms.tasks import cancel_all
from rostether.relay.action_relay import ActionRelay, action_entries
from rostether.relay.item import ItemKind, RelayItem
from rostether.relay.relay_filter import RelayDirection, RelayFilter
from rostether.relay.service_relay import ServiceRelay
from rostether.relay.side import RelaySide
from rostether.relay.topic_relay import TopicRelay
from rostether.ros2.actions.board_graph import BoardJoin

# The pause before a request that a graph refused is repeated; graphs recover within seconds.
RETRY_S = 2.0

# The time for relays and boards in both graphs to see a new relay: ROS 1 shows changes after a second.
DISCOVERY_S = 2.0

# How long a relay waits for each older one: until the graphs show the items that the older one relays.
OLDER_RELAY_WAIT_S = 1.5

# How often the relay checks whether other relays still run. The copies of a killed relay are missing until
# the next check.
CHECK_S = 3.0

# How often a new relay checks for its first snapshot of a graph.
SEEN_POLL_S = 0.05


class Relay:
    """Relays the items that `relay_filter` chooses; `report` gets a line for each start, end and error.

    `actions` is needed to relay actions; then `first` is ROS 1 and `second` is ROS 2.
    """

    def __init__(
        self,
        first: RelaySide,
        second: RelaySide,
        relay_filter: RelayFilter,
        report: Report,
        actions: BoardJoin | None = None,
    ) -> None:
        self._sides = (first, second)
        self._actions_join = actions
        self._filter = relay_filter
        self._report = report
        self._mark = new_relay_mark()
        self._snapshots: dict[str, Snapshot] = {}
        self._marked = MarkedNodes()
        # Nodes that need no relay, and killed relays, whose endpoints a graph may still list.
        self._skip_nodes: set[str] = set()
        self._gone: set[str] = set()
        self._left_out: dict[str, str] = {}
        self._has_changed = asyncio.Event()
        self._relaying: dict[RelayItem, asyncio.Task[None]] = {}
        self._ending: dict[RelayItem, asyncio.Task[None]] = {}

    async def run(self) -> None:
        """Relay until canceled. Raises GraphError when a graph shuts down the relay's node."""
        marks: list[Publisher] = []
        tasks: list[asyncio.Future[None]] = []
        try:
            marks += [await side.graph.advertise(self._mark, MARK_TYPE) for side in self._sides]
            tasks += [asyncio.ensure_future(self._follow(side)) for side in self._sides]
            tasks += [asyncio.ensure_future(self._forget_gone(side)) for side in self._sides]
            leaving = [asyncio.ensure_future(self._leave(side)) for side in self._sides]
            arranging: asyncio.Future[None] = asyncio.ensure_future(self._arrange_on_changes())
            tasks += [*leaving, arranging]
            done, _ = await asyncio.wait((*leaving, arranging), return_when=asyncio.FIRST_COMPLETED)
            for ended in done:
                await ended
        finally:
            tasks += [*self._relaying.values(), *self._ending.values()]
            await cancel_all(*tasks)
            await asyncio.gather(*(mark.close() for mark in marks), return_exceptions=True)

    async def _leave(self, side: RelaySide) -> None:
        reason = await side.graph.wait_closed()
        raise GraphError(f"the relay's node has left {side.name}: {reason}; start the relay again")

    async def _follow(self, side: RelaySide) -> None:
        while True:
            try:
                async for snapshot in side.graph.changes():
                    self._snapshots[side.name] = snapshot
                    self._find_shared_nodes()
                    self._has_changed.set()
            except GraphError as error:
                self._report(Level.WARN, f"cannot list the nodes of {side.name}: {error}; trying again")
            # Running relays continue: a graph that does not answer for a moment may still work.
            await asyncio.sleep(RETRY_S)

    def _find_shared_nodes(self) -> None:
        """Find the other nodes that are in both graphs."""
        own = {side.graph.node_name for side in self._sides}
        marked = MarkedNodes.find(self._snapshots.values())
        self._gone &= {name for snapshot in self._snapshots.values() for name in snapshot.nodes}
        relays = {name: mark for name, mark in marked.relays.items() if name not in own | self._gone}
        for name in sorted(relays.keys() - self._marked.relays.keys()):
            self._report(Level.INFO, f"the relay {name} connects the same graphs: its copies are not relayed")
        for name in sorted(marked.joint - self._marked.joint):
            self._report(Level.INFO, f"{name} is a node of both graphs: its messages are not relayed")
        self._marked = MarkedNodes(relays, marked.joint)
        replace_names(self._skip_nodes, self._marked.names | self._gone)

    async def _forget_gone(self, side: RelaySide) -> None:
        """Find relays that were killed, and remove their registrations from the graph of a side."""
        if side.forget_if_gone is None:
            return
        # The first check ends before items are chosen, so that a killed relay is not used as a source.
        while side.name not in self._snapshots:  # noqa: ASYNC110 - the first snapshot takes milliseconds
            await asyncio.sleep(SEEN_POLL_S)
        while True:
            known = relay_marks(self._snapshots.get(side.name, Snapshot()))
            for name in known.keys() - self._gone - {side.graph.node_name}:
                try:
                    is_gone = await side.forget_if_gone(name)
                except RostetherError as error:
                    self._report(Level.WARN, f"cannot check whether the relay {name} still runs: {error}")
                    continue
                if is_gone:
                    self._gone.add(name)
                    self._report(Level.INFO, f"the relay {name} was killed: removed its registrations")
                    self._find_shared_nodes()
                    self._has_changed.set()
            await asyncio.sleep(CHECK_S if known else RETRY_S)

    async def _arrange_on_changes(self) -> None:
        await asyncio.sleep(DISCOVERY_S)
        while True:
            await self._has_changed.wait()
            self._has_changed.clear()
            if len(self._snapshots) == len(self._sides):
                left_out: dict[str, str] = {}
                self._arrange(set(self._items(left_out)))
                for text, reason in left_out.items():
                    if self._left_out.get(text) != reason:
                        self._report(Level.INFO, f"not relaying {text}: {reason}")
                self._left_out = left_out

    def _arrange(self, items: set[RelayItem]) -> None:
        for item in self._relaying.keys() - items:
            task = self._ending[item] = self._relaying.pop(item)
            task.add_done_callback(partial(self._forget, item))
            task.cancel()
        # An item that is chosen again while its relay ends is relayed again after that.
        for item in sorted(items - self._relaying.keys() - self._ending.keys(), key=lambda each: each.text):
            self._relaying[item] = asyncio.get_running_loop().create_task(self._relay_item(item))

    def _forget(self, item: RelayItem, _: object) -> None:
        del self._ending[item]
        self._has_changed.set()

    def _items(self, left_out: dict[str, str]) -> Iterator[RelayItem]:
        """Yield the items to relay; `left_out` gets those that another relay relays, with the reason."""
        first, second = self._sides
        for item, there in (
            *self._topics(first, second, RelayDirection.FIRST_TO_SECOND),
            *self._topics(second, first, RelayDirection.SECOND_TO_FIRST),
            *self._services(first, second),
            *self._services(second, first),
            *self._actions(),
        ):
            other = self._other_relay(item.target.graph.node_name, there)
            if other:
                left_out[item.text] = f"the relay {other} already relays it"
            else:
                yield item

    def _topics(
        self, source: RelaySide, target: RelaySide, direction: RelayDirection
    ) -> Iterator[tuple[RelayItem, tuple[str, ...]]]:
        """Yield the topics of one side to relay, each with its publishers on the other side."""
        there = self._snapshots[target.name].topics
        own = {source.graph.node_name, *self._skip_nodes}
        for name, topic in self._snapshots[source.name].topics.items():
            if is_mark(name) or own.issuperset(topic.publishers):
                continue
            if self._filter.relays_topic(name, direction):
                yield (
                    RelayItem(ItemKind.TOPIC, name, source, target),
                    there[name].publishers if name in there else (),
                )

    def _services(self, source: RelaySide, target: RelaySide) -> Iterator[tuple[RelayItem, tuple[str, ...]]]:
        """Yield the services of one side to relay, each with its providers on the other side."""
        there = self._snapshots[target.name].services
        own = {source.graph.node_name, *self._skip_nodes}
        relays = {target.graph.node_name, *self._marked.relays, *self._gone}
        for name, service in self._snapshots[source.name].services.items():
            chosen = self._filter.service(name)
            if chosen is None or own.issuperset(service.providers):
                continue
            # If both graphs have a service, each keeps its own.
            providers = there[name].providers if name in there else ()
            if relays.issuperset(providers):
                yield RelayItem(ItemKind.SERVICE, name, source, target, chosen.type), providers

    def _actions(self) -> Iterator[tuple[RelayItem, tuple[str, ...]]]:
        """Yield the actions of one side to relay, each with its servers on the other side."""
        if self._actions_join is None:
            return
        entries = action_entries(*(self._snapshots[side.name] for side in self._sides))
        for number, (source, target) in enumerate((self._sides, self._sides[::-1])):
            own = {source.graph.node_name, *self._skip_nodes}
            relays = {target.graph.node_name, *self._marked.relays, *self._gone}
            for name, entry in entries[number].items():
                there = entries[1 - number].get(name)
                servers = () if there is None else there.servers
                is_wanted = self._filter.relays_action(name) and not own.issuperset(entry.servers)
                # If both graphs have an action, each keeps its own.
                if is_wanted and relays.issuperset(servers):
                    yield RelayItem(ItemKind.ACTION, name, source, target, entry.type), servers

    def _other_relay(self, own_name: str, nodes: Iterable[str]) -> str:
        """Return the other relay among `nodes` that keeps the item, or an empty string."""
        relays = self._marked.relays
        others = sorted((relays[name], name) for name in nodes if name in relays)
        if not others or (own_name in nodes and self._mark < others[0][0]):
            return ""
        return others[0][1]

    async def _relay_item(self, item: RelayItem) -> None:
        reported = ""
        while True:
            # Older relays have priority; this task is canceled if one of them relays the item.
            await asyncio.sleep(
                OLDER_RELAY_WAIT_S * sum(mark < self._mark for mark in self._marked.relays.values())
            )
            relay = self._new_relay(item)
            is_open = False
            try:
                await relay.open()
                is_open = True
                while True:
                    self._report(Level.INFO, f"relaying {item.text} ({relay.type_name})")
                    await relay.wait_for_new_type()
            except RostetherError as error:
                if str(error) != reported:
                    reported = str(error)
                    self._report(Level.ERROR, f"cannot relay {item.text}: {error}")
            finally:
                await self._end(relay, item, was_open=is_open)
            await asyncio.sleep(RETRY_S)

    def _new_relay(self, item: RelayItem) -> TopicRelay | ServiceRelay | ActionRelay:
        if item.kind is ItemKind.TOPIC:
            return TopicRelay(item.name, item.source, item.target, self._skip_nodes)
        if item.kind is ItemKind.SERVICE:
            return ServiceRelay(item.name, item.source, item.target, item.chosen_type)
        assert self._actions_join is not None
        ros1, _ = self._sides
        to_ros2 = item.source is ros1
        return ActionRelay(item.name, item.chosen_type, ros1.graph, self._actions_join, to_ros2=to_ros2)

    async def _end(
        self, relay: TopicRelay | ServiceRelay | ActionRelay, item: RelayItem, *, was_open: bool
    ) -> None:
        try:
            await relay.close()
        except RostetherError as error:
            self._report(Level.WARN, f"{item.text} may still be listed: {error}")
        if was_open:
            self._report(Level.INFO, f"no longer relaying {item.text}")
