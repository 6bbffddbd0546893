"""Watches parameters: those of this node in its store, those of other nodes through /parameter_events."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Sequence

from rostether.errors import GraphError, SerializationError
from rostether.graph.parameter_watch import ParameterWatch
from rostether.graph.ports import Graph, ParamValue, Subscriber
from rostether.names.graph_name import is_in_namespace
from rostether.ros2.parameters.services import PARAMETER_EVENTS
from rostether.ros2.parameters.store import Changes, OwnParameters
from rostether.ros2.rcl_interfaces import rcl_interfaces


class Ros2ParameterWatches:
    """All watches of one node; it subscribes to the events as long as there are watches.

    `fetch` returns the value of a parameter, None if it is unset.
    """

    def __init__(
        self, own: OwnParameters, graph: Graph, fetch: Callable[[str], Awaitable[ParamValue]]
    ) -> None:
        self._own = own
        self._graph = graph
        self._fetch = fetch
        self._watches: list[Ros2ParameterWatch] = []
        self._subscriber: Subscriber | None = None
        # Subscribing and unsubscribing run one at a time.
        self._lock = asyncio.Lock()

    async def add(self, name: str, on_change: Callable[[ParamValue], None]) -> Ros2ParameterWatch:
        """Call back with the value now and after every change. Raises GraphError."""
        async with self._lock:
            if self._subscriber is None:
                self._subscriber = await self._graph.subscribe(
                    PARAMETER_EVENTS, rcl_interfaces().message("ParameterEvent"), self._handle_events
                )
                self._own.listen(self._handle_own_changes)
        watch = Ros2ParameterWatch(name, on_change, self._remove, self._fetch)
        self._watches.append(watch)
        await watch.start()
        return watch

    async def _remove(self, watch: Ros2ParameterWatch) -> None:
        if watch in self._watches:
            self._watches.remove(watch)
        async with self._lock:
            if not self._watches and self._subscriber is not None:
                self._own.unlisten(self._handle_own_changes)
                subscriber, self._subscriber = self._subscriber, None
                await subscriber.close()

    async def close(self) -> None:
        """End all watches."""
        for watch in list(self._watches):
            await watch.close()

    def _handle_own_changes(self, changes: Changes) -> None:
        for watch in self._watches:
            watch.refresh_soon()

    def _handle_events(self, payloads: Sequence[bytes]) -> None:
        codec = rcl_interfaces().codec("ParameterEvent")
        nodes = set()
        for payload in payloads:
            try:
                nodes.add(codec.decode(payload).node)
            except SerializationError:
                continue  # Not a message of the topic's type.
        nodes.discard(self._graph.node_name)
        for watch in self._watches:
            # The name of a watch may be that of a node, of one of its parameters, or of a namespace above it.
            if any(is_in_namespace(watch.name, each) or is_in_namespace(each, watch.name) for each in nodes):
                watch.refresh_soon()


class Ros2ParameterWatch(ParameterWatch):
    """Fetches the value again after each event that may concern it."""

    def __init__(
        self,
        name: str,
        on_change: Callable[[ParamValue], None],
        on_close: Callable[[Ros2ParameterWatch], Awaitable[None]],
        fetch: Callable[[str], Awaitable[ParamValue]],
    ) -> None:
        super().__init__(name, on_change, on_close)
        self._fetch = fetch
        self._is_started = False
        self._is_outdated = False
        self._refreshing: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Report the current value, and later changes."""
        value: ParamValue = None
        with contextlib.suppress(GraphError, SerializationError):
            value = await self._fetch(self.name)
        self.report(value)
        self._is_started = True
        if self._is_outdated:
            self.refresh_soon()

    def refresh_soon(self) -> None:
        """Fetch the value, and report it if it has changed."""
        self._is_outdated = True
        if self._is_started and self._refreshing is None and not self.is_closed:
            self._refreshing = asyncio.get_running_loop().create_task(self._refresh())

    async def close(self) -> None:
        """Stop watching. Idempotent."""
        if self._refreshing is not None:
            self._refreshing.cancel()
        await super().close()

    async def _refresh(self) -> None:
        try:
            while self._is_outdated:
                self._is_outdated = False
                # If its node does not answer, the last value is kept.
                with contextlib.suppress(GraphError, SerializationError):
                    self.report(await self._fetch(self.name))
        finally:
            self._refreshing = None
