"""ROS time on ROS 2: the wall clock, or the time of /clock while the parameter use_sim_time is true."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence

from rostether.errors import GraphError
from rostether.graph.ports import Graph, Subscriber
from rostether.graph.ros_clock import CLOCK_TOPIC, CLOCK_TYPE, decode_clock, wall_time
from rostether.ros2.parameters.store import USE_SIM_TIME, Changes, ParameterStore
from rostether.rostime import Time

_log = logging.getLogger("rostether.ros2")


class NodeClock:
    """Returns the time of one node; use_sim_time may change at any time, as in rclcpp."""

    def __init__(
        self, store: ParameterStore, graph: Graph, wall_time: Callable[[], Time] = wall_time
    ) -> None:
        self._store = store
        self._graph = graph
        self._wall_time = wall_time
        self._simulated: Time | None = None
        self._subscriber: Subscriber | None = None
        self._following: asyncio.Task[None] | None = None
        self._is_closed = False

    async def open(self) -> None:
        """Follow the parameter until `close`. Raises GraphError."""
        self._store.listen(self._handle_changes)
        await self._follow()

    def now(self) -> Time:
        """Return the time; simulated time is zero before the first message of /clock."""
        return self._wall_time() if self._simulated is None else self._simulated

    async def close(self) -> None:
        """Stop following. Idempotent."""
        self._is_closed = True
        self._store.unlisten(self._handle_changes)
        if self._following is not None:
            await self._following
        if self._subscriber is not None:
            await self._subscriber.close()

    def _handle_changes(self, changes: Changes) -> None:
        if USE_SIM_TIME in changes.names:
            self._switch()
            if self._following is None:
                self._following = asyncio.get_running_loop().create_task(self._follow_contained())

    def _switch(self) -> bool:
        is_simulated = self._store.get(USE_SIM_TIME).value is True
        if not is_simulated:
            self._simulated = None
        elif self._simulated is None:
            self._simulated = Time()
        return is_simulated

    async def _follow_contained(self) -> None:
        try:
            await self._follow()
        except GraphError as error:
            _log.error("%s cannot follow %s: %s", self._graph.node_name, CLOCK_TOPIC, error)
        finally:
            self._following = None

    async def _follow(self) -> None:
        while not self._is_closed and self._switch() is (self._subscriber is None):
            if self._subscriber is None:
                self._subscriber = await self._graph.subscribe(CLOCK_TOPIC, CLOCK_TYPE, self._handle_clock)
            else:
                subscriber, self._subscriber = self._subscriber, None
                await subscriber.close()

    def _handle_clock(self, payloads: Sequence[bytes]) -> None:
        if self._simulated is not None:
            self._simulated = decode_clock(payloads[-1]) or self._simulated
