"""A graph in which every call fails, to test that other graphs are not affected."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping
from typing import Any, NoReturn

from rostether.errors import MasterUnreachableError
from rostether.graph.joint_graph import JointGraph
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph, Level, Snapshot
from rostether.names.graph_name import join, resolve_name
from rostether.rostime import Time


class BrokenGraph:
    """A `Graph` whose master never answers."""

    def __init__(self, node_name: str, namespace: str = "/") -> None:
        self.node_name = node_name
        self._namespace = namespace
        self._closed = asyncio.Event()

    def resolve(self, name: str) -> str:
        return resolve_name(name, namespace=self._namespace, node_name=self.node_name)

    async def _fail(self, *_: Any, **__: Any) -> NoReturn:
        await asyncio.sleep(0)
        raise MasterUnreachableError("no answer")

    advertise = subscribe = advertise_service = call_service = _fail
    get_param = set_param = delete_param = has_param = search_param = list_params = watch_param = _fail

    async def snapshot(self) -> Snapshot:
        raise MasterUnreachableError("no answer")

    def log(self, level: Level, text: str) -> None:
        pass

    def now(self) -> Time:
        return Time()

    async def changes(self) -> AsyncIterator[Snapshot]:
        raise MasterUnreachableError("no answer")
        yield Snapshot()

    async def close(self) -> None:
        self._closed.set()

    async def wait_closed(self) -> str:
        await self._closed.wait()
        return "closed"


class HalfBrokenNetwork:
    """Makes nodes that are in a graph in memory and in a broken one; `join` is a `JoinGraph`."""

    def __init__(self) -> None:
        self.network = MemoryNetwork()

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        working = await self.network.join(node_name, namespace=namespace, remappings=remappings)
        return JointGraph([working, BrokenGraph(join(namespace, node_name), namespace)])
