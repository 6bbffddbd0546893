"""The time stamps of messages for clients: the wall clock, or /clock under /use_sim_time."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable

from rostether.errors import RostetherError
from rostether.gateways.shared_subscriptions import Batch, SharedSubscription, SharedSubscriptions
from rostether.graph.ports import Graph, ParamValue, Watch
from rostether.graph.ros_clock import CLOCK_TOPIC, decode_clock
from rostether.mechanisms.tasks import start_task

_USE_SIM_TIME = "/use_sim_time"
_log = logging.getLogger("rostether.gateways")


class SimClock:
    """Follows /use_sim_time and /clock; `on_time` gets each time.

    `on_change` is called after a change between the wall clock and /clock.
    """

    def __init__(
        self,
        graph: Graph,
        shared: SharedSubscriptions,
        on_time: Callable[[int], None],
        on_change: Callable[[], None],
    ) -> None:
        # Whether the time comes from /clock.
        self.is_simulated = False
        self._graph = graph
        self._shared = shared
        self._on_time = on_time
        self._on_change = on_change
        self._time_ns = 0
        self._watch: Watch | None = None
        self._share: SharedSubscription | None = None
        self._following: set[asyncio.Task[None]] = set()
        self._lock = asyncio.Lock()

    async def start(self) -> None:
        """Find out which clock is used, and watch for changes."""
        try:
            self._watch = await self._graph.watch_param(_USE_SIM_TIME, self._handle_use_sim_time)
        except RostetherError:
            # Without the parameter, the wall clock is used.
            return

    def now_ns(self) -> int:
        """Return the time in nanoseconds; zero before the first /clock."""
        return self._time_ns if self.is_simulated else time.time_ns()

    async def close(self) -> None:
        """Stop following."""
        if self._watch is not None:
            await self._watch.close()
        self.is_simulated = False
        await self._follow()

    def _handle_use_sim_time(self, value: ParamValue) -> None:
        if (value is True) == self.is_simulated:
            return
        self.is_simulated = value is True
        self._time_ns = 0
        start_task(self._following, self._follow())
        self._on_change()

    async def _follow(self) -> None:
        """Subscribe to /clock while it is used."""
        async with self._lock:
            if self.is_simulated and self._share is None:
                try:
                    self._share = await self._shared.subscribe(CLOCK_TOPIC, self._handle_clock)
                except RostetherError as error:
                    _log.warning("cannot subscribe to %s, so clients get no time: %s", CLOCK_TOPIC, error)
            elif not self.is_simulated and self._share is not None:
                share, self._share = self._share, None
                await share.close()

    def _handle_clock(self, batch: Batch) -> None:
        now = decode_clock(batch.payloads[-1])
        if self.is_simulated and now is not None:
            self._time_ns = now.to_ns()
            self._on_time(self._time_ns)
