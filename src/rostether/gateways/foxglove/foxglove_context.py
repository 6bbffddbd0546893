"""The state that the clients of one gateway share."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

from msgspec import Struct, field

from rostether.errors import RostetherError
from rostether.gateways.foxglove.assets import Assets
from rostether.gateways.foxglove.channels import Channels
from rostether.gateways.foxglove.connection_graph import ConnectionGraph
from rostether.gateways.foxglove.parameters import Parameters
from rostether.gateways.foxglove.recordings import RecordingReports
from rostether.gateways.foxglove.services import Services
from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings
from rostether.gateways.foxglove.sim_clock import SimClock
from rostether.gateways.shared_subscriptions import SharedSubscriptions
from rostether.gateways.teleop.teleop import Teleop
from rostether.graph.ports import Graph
from rostether.mechanisms.tasks import start_task
from rostether.serde.store import TypeStore


class FoxgloveContext(Struct, frozen=True, kw_only=True):
    """The graph and everything that clients share; made by `FoxgloveGateway`."""

    graph: Graph
    store: TypeStore
    settings: FoxgloveSettings
    shared: SharedSubscriptions
    channels: Channels
    services: Services
    parameters: Parameters
    connections: ConnectionGraph
    assets: Assets
    clock: SimClock
    teleop: Teleop | None
    recordings: RecordingReports | None
    _work: set[asyncio.Task[None]] = field(default_factory=set)

    @property
    def limits(self) -> FoxgloveLimits:
        """The limits of the gateway and its clients."""
        return self.settings.limits

    def run(self, work: Coroutine[Any, Any, None]) -> None:
        """Run work that does not end with its client, such as a cleanup; errors of the graph are ignored."""
        start_task(self._work, _contained(work))

    async def close(self) -> None:
        """End everything on the graph."""
        while self._work:
            await asyncio.wait(self._work)
        if self.teleop is not None:
            await self.teleop.close()
        if self.recordings is not None:
            await self.recordings.close()
        await asyncio.gather(
            self.channels.close(), self.services.close(), self.parameters.close(), self.clock.close()
        )
        await self.shared.close()


async def _contained(work: Coroutine[Any, Any, None]) -> None:
    try:
        await work
    except RostetherError:
        # The node has left the graph, and all its endpoints with it.
        return
