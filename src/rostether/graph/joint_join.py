"""Joins several graphs as one node: immediately if possible, the others as soon as they are reachable."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import aclosing
from functools import partial

from rostether.errors import GraphError, RostetherError
from rostether.graph.joint_graph import JointGraph
from rostether.graph.joint_handle import retry_backoff
from rostether.graph.joint_marks import MARK_TYPE, MarkedNodes, new_joint_mark, replace_names
from rostether.graph.ports import Graph, JoinGraph, Level

# The shortest pause between two checks of the graphs: many boards that connect together cost one check.
POLL_INTERVAL_S = 0.25

_log = logging.getLogger("rostether.graph")


class JointJoin:
    """A `graph.ports.JoinGraph` over others, the most important first."""

    def __init__(self, joins: Sequence[JoinGraph]) -> None:
        self._joins = tuple(joins)
        self._mark = new_joint_mark()
        # The number of nodes of this process by name: a node may join before its predecessor has left.
        self._own_nodes: Counter[str] = Counter()
        self._seen = MarkedNodes()
        self._joint_nodes: set[str] = set()
        self._relays: set[str] = set()
        # One of our nodes searches for all of them.
        self._search_lock = asyncio.Lock()

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> JointGraph:
        """Join every graph that is reachable now. Raises GraphError if none is, InvalidNameError."""
        joins = [partial(join, node_name, namespace=namespace, remappings=remappings) for join in self._joins]
        results = await asyncio.gather(*(join() for join in joins), return_exceptions=True)
        graphs = [result for result in results if not isinstance(result, BaseException)]
        wrong = [each for each in results if isinstance(each, BaseException)]
        serious = [each for each in wrong if not isinstance(each, GraphError)]
        if serious or not graphs:
            await asyncio.gather(*(graph.close() for graph in graphs))
            raise (serious or wrong)[0]
        joint = JointGraph(graphs, self._joint_nodes, self._relays)
        joint.run_until_closed(self._list_node(joint.node_name))
        joint.run_until_closed(self._poll(joint))
        for position, result in enumerate(results):
            if isinstance(result, GraphError):
                _log.warning("%s is not in every graph yet: %s", joint.node_name, result)
                joint.run_until_closed(_join_later(joint, position, joins[position]))
        try:
            await joint.advertise(self._mark, MARK_TYPE)
        except RostetherError as error:
            _log.warning(
                "relays do not recognize that %s is in several graphs, and relay its messages again: %s",
                joint.node_name,
                error,
            )
        return joint

    async def _list_node(self, node_name: str) -> None:
        self._own_nodes[node_name] += 1
        self._update()
        try:
            await asyncio.Event().wait()
        finally:
            self._own_nodes[node_name] -= 1
            if not self._own_nodes[node_name]:
                del self._own_nodes[node_name]
            self._update()

    async def _poll(self, joint: JointGraph) -> None:
        async with self._search_lock, aclosing(joint.changes_of_each()) as changes:
            async for snapshots in changes:
                self._seen = MarkedNodes.find(snapshots)
                for name in self._seen.relays.keys() - self._relays:
                    joint.log(
                        Level.INFO, f"{name} is a relay between the same graphs: its copies are not relayed"
                    )
                self._update()
                await asyncio.sleep(POLL_INTERVAL_S)

    def _update(self) -> None:
        replace_names(self._relays, set(self._seen.relays))
        replace_names(self._joint_nodes, {*self._own_nodes, *self._seen.joint})


async def _join_later(joint: JointGraph, position: int, join: Callable[[], Awaitable[Graph]]) -> None:
    backoff = retry_backoff()
    while True:
        await asyncio.sleep(backoff.next_delay_s())
        with contextlib.suppress(GraphError):
            graph = await join()
            break
    await joint.add(graph, position)
