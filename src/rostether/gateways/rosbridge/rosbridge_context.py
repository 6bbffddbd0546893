"""The objects that all clients of a rosbridge server share."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec import Struct, field

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.gateways.shared_subscriptions import SharedSubscriptions
from rostether.graph.ports import Graph
from rostether.mechanisms.tasks import start_task
from rostether.serde.store import TypeStore

if TYPE_CHECKING:
    from rostether.gateways.rosbridge.client_publication import ClientPublication
    from rostether.gateways.rosbridge.message_forms import MessageForms
    from rostether.gateways.rosbridge.offered_services import OfferedServices
    from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi
    from rostether.gateways.rosbridge.service_types import ServiceTypes

# As in rosbridge, a topic stays advertised for this time after its client disconnects: pages are reloaded.
_LINGER_S = 10.0

# The limit of lingering publications; above it, the oldest end early.
MAX_LINGERING = 1000


class RosbridgeContext(Struct, eq=False):
    """The graph and everything that clients share; made by `RosbridgeServer`. `warn` reports a warning."""

    graph: Graph
    store: TypeStore
    settings: RosbridgeSettings
    shared: SharedSubscriptions
    forms: MessageForms
    service_types: ServiceTypes
    offered: OfferedServices
    local_services: Rosapi | None
    warn: Callable[[str], None]
    _lingering: dict[ClientPublication, asyncio.TimerHandle] = field(default_factory=dict)
    _ending: set[asyncio.Task[None]] = field(default_factory=set)

    def linger(self, publication: ClientPublication) -> None:
        """End a publication after `_LINGER_S`."""
        while len(self._lingering) >= MAX_LINGERING:
            oldest = next(iter(self._lingering))
            self._lingering[oldest].cancel()
            self._end(oldest)
        timer = asyncio.get_running_loop().call_later(_LINGER_S, self._end, publication)
        self._lingering[publication] = timer

    async def end_lingering(self, topic: str) -> bool:
        """Immediately end a lingering publication, by its full topic name; return whether there was one."""
        found = [each for each in self._lingering if each.topic == topic]
        for publication in found:
            self._lingering.pop(publication).cancel()
            await _close(publication)
        return bool(found)

    async def close(self) -> None:
        """End all lingering publications."""
        for publication, timer in list(self._lingering.items()):
            timer.cancel()
            self._end(publication)
        await asyncio.gather(*self._ending, return_exceptions=True)

    def _end(self, publication: ClientPublication) -> None:
        self._lingering.pop(publication, None)
        start_task(self._ending, _close(publication))


async def _close(publication: ClientPublication) -> None:
    try:
        await publication.close()
    except RostetherError:
        # The node has left the graph, and its publications with it.
        return
