"""The common part of all graph implementations: a node's name resolution, and its orderly end."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Mapping

from rostether.errors import GraphError
from rostether.names.graph_name import resolve_name, resolve_remappings


class NodeMembership(ABC):
    """The base of a `graph.ports.Graph`: one node from its join until it has left.

    `node_name` is fully qualified; relative names resolve against `namespace`.
    """

    def __init__(self, node_name: str, namespace: str, remappings: Mapping[str, str]) -> None:
        self.node_name = node_name
        self._namespace = namespace
        self._remappings = resolve_remappings(remappings, namespace=namespace, node_name=node_name)
        self._closing: asyncio.Task[None] | None = None
        self._closed = asyncio.Event()
        self._reason = ""

    def resolve(self, name: str) -> str:
        """Return the fully qualified, remapped form of a name. Raises InvalidNameError."""
        return resolve_name(
            name, namespace=self._namespace, node_name=self.node_name, remappings=self._remappings
        )

    async def close(self, reason: str = "closed") -> None:
        """Leave the graph: everything advertised, subscribed or watched ends. Idempotent."""
        await asyncio.shield(self._start_close(reason))

    async def wait_closed(self) -> str:
        """Wait until the node has left, by `close` or by a shutdown request; return the reason."""
        await self._closed.wait()
        return self._reason

    @abstractmethod
    async def _end(self) -> None:
        """End everything that belongs to the node; called once."""

    def _start_close(self, reason: str) -> asyncio.Task[None]:
        if self._closing is None:
            self._reason = self._reason or reason
            self._closing = asyncio.ensure_future(self._close())
        return self._closing

    async def _close(self) -> None:
        try:
            await self._end()
        finally:
            self._closed.set()

    def _check_open(self) -> None:
        if self._closing is not None:
            raise GraphError(f"node {self.node_name} has left the graph; join again")
