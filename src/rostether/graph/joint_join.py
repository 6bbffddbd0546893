"""Joining several graphs as one node: those that can be joined at once, the others as soon as they can."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial

from rostether.errors import GraphError
from rostether.graph.joint_graph import JointGraph
from rostether.graph.joint_parts import retry_backoff
from rostether.graph.ports import Graph, JoinGraph

_log = logging.getLogger("rostether.graph")


class JointJoin:
    """A `graph.ports.JoinGraph` over others, the most important first."""

    def __init__(self, joins: Sequence[JoinGraph]) -> None:
        self._joins = tuple(joins)
        # By name, how many there are: one may come before its predecessor has left.
        self._joint_nodes: Counter[str] = Counter()

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> JointGraph:
        """Join every graph that can be joined now. Raises when none can, or when a name is wrong."""

        async def join(join_one: JoinGraph) -> Graph | GraphError:
            try:
                return await join_one(node_name, namespace=namespace, remappings=remappings)
            except GraphError as error:
                return error

        results = await asyncio.gather(*map(join, self._joins), return_exceptions=True)
        graphs = [result for result in results if not isinstance(result, BaseException)]
        wrong = [each for each in results if isinstance(each, BaseException)]
        serious = [each for each in wrong if not isinstance(each, GraphError)]
        if serious or not graphs:
            await asyncio.gather(*(graph.close() for graph in graphs))
            raise (serious or wrong)[0]
        joint = JointGraph(graphs, self._joint_nodes)
        joint.run_until_closed(partial(self._be_listed, joint.node_name))
        for position, result in enumerate(results):
            if isinstance(result, GraphError):
                _log.warning("%s is not in every graph yet: %s", joint.node_name, result)
                self._join_later(joint, position, node_name, namespace, remappings)
        return joint

    async def _be_listed(self, node_name: str) -> None:
        self._joint_nodes[node_name] += 1
        try:
            await asyncio.Event().wait()
        finally:
            self._joint_nodes[node_name] -= 1
            if not self._joint_nodes[node_name]:
                del self._joint_nodes[node_name]

    def _join_later(
        self,
        joint: JointGraph,
        position: int,
        node_name: str,
        namespace: str,
        remappings: Mapping[str, str] | None,
    ) -> None:
        async def keep_trying() -> None:
            backoff = retry_backoff()
            while True:
                await asyncio.sleep(backoff.next_delay_s())
                with contextlib.suppress(GraphError):
                    graph = await self._joins[position](node_name, namespace=namespace, remappings=remappings)
                    break
            await joint.add(graph, position)

        joint.run_until_closed(keep_trying)
