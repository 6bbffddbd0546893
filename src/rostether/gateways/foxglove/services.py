"""The services of a graph as clients see them, and calls of them with raw or JSON requests."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from typing import TypeAlias

from rostether.errors import RostetherError
from rostether.gateways.foxglove.encoding import Encoder, encode_json
from rostether.gateways.foxglove.server_messages import JSON_ENCODING, AdvertisedService
from rostether.gateways.foxglove.settings import NameFilter
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Graph, Snapshot
from rostether.mechanisms.tasks import cancel_all
from rostether.msgdef.interface import ANY_TYPE
from rostether.serde.store import TypeStore

# Asks the server of a service for its type, which a ROS 1 master does not know. Raises RostetherError.
FindServiceType: TypeAlias = Callable[[str], Awaitable[str]]

# More than any graph has: a ROS 1 node of roscpp has two, one of ROS 2 seven.
MAX_SERVICES = 20_000

# Each request opens a connection to the server of a service.
_ASKED_AT_ONCE = 8

# A longer response may take longer than 10 ms to convert to JSON.
_MAX_QUICK_ANSWER_BYTES = 16 << 10

# A node that has just registered may not answer yet; a node that has ended never does.
_RETRY_S = (1.0, 2.0, 5.0, 10.0, 30.0)


class Services:
    """The services of one gateway; calls `on_offer` for new services and `on_end` for removed ones."""

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        offered: NameFilter,
        find_type: FindServiceType | None,
        on_offer: Callable[[Sequence[AdvertisedService]], None],
        on_end: Callable[[Sequence[AdvertisedService]], None],
    ) -> None:
        self.by_id: dict[int, AdvertisedService] = {}
        self._graph = graph
        self._store = store
        self._offered = offered
        self._find_type = find_type
        self._on_offer = on_offer
        self._on_end = on_end
        self._by_name: dict[str, AdvertisedService] = {}
        # The providers and the listed type of each service: a restarted server may have another type.
        self._providers: dict[str, tuple[tuple[str, ...], str]] = {}
        self._asking: dict[str, asyncio.Task[None]] = {}
        self._asked_at_once = asyncio.Semaphore(_ASKED_AT_ONCE)
        self._next_id = 1

    def update(self, snapshot: Snapshot) -> None:
        """Update the services."""
        listed = {
            service.name: (service.providers, service.type)
            for service in snapshot.services.values()
            if service.providers and self._offered.includes(service.name)
        }
        ended: list[AdvertisedService] = []
        for name in [name for name, known in self._providers.items() if listed.get(name) != known]:
            del self._providers[name]
            if task := self._asking.pop(name, None):
                task.cancel()
            if service := self._by_name.pop(name, None):
                del self.by_id[service.id]
                ended.append(service)
        if ended:
            self._on_end(ended)
        new: list[AdvertisedService] = []
        for name, (providers, type_name) in listed.items():
            if name in self._providers or len(self._providers) >= MAX_SERVICES:
                continue
            self._providers[name] = (providers, type_name)
            if type_name != ANY_TYPE:
                new += self._add(name, type_name)
            elif self._find_type is not None:
                self._asking[name] = asyncio.ensure_future(self._ask(name, self._find_type))
        if new:
            self._on_offer(new)

    async def call(
        self, service: AdvertisedService, encoding: str, payload: bytes, timeout_s: float
    ) -> bytes:
        """Call a service; request and response have the same encoding. Raises RostetherError."""
        types = service.type
        encoder = Encoder.of(encoding, self._store.codec(types.request.name), "requests")
        request = await encoder.convert(payload)
        answer = await self._graph.call_service(service.name, types, request, timeout_s=timeout_s)
        if encoding != JSON_ENCODING:
            return answer
        codec = self._store.codec(types.response.name)
        if len(answer) > _MAX_QUICK_ANSWER_BYTES:
            return await asyncio.to_thread(lambda: encode_json(codec.decode(answer)))
        return encode_json(codec.decode(answer))

    async def close(self) -> None:
        """Stop asking for types."""
        await cancel_all(*self._asking.values())

    def _add(self, name: str, type_name: str) -> list[AdvertisedService]:
        try:
            service_type = self._store.registry.service_type(short_type(type_name))
        except RostetherError:
            # Without a definition, no client can call it.
            return []
        service = AdvertisedService(self._next_id, name, service_type)
        self._next_id += 1
        self._by_name[name] = self.by_id[service.id] = service
        return [service]

    async def _ask(self, name: str, find_type: FindServiceType) -> None:
        for delay_s in (*_RETRY_S, None):
            try:
                async with self._asked_at_once:
                    type_name = await find_type(name)
            except RostetherError:
                if delay_s is None:
                    break
                await asyncio.sleep(delay_s)
                continue
            if new := self._add(name, type_name):
                self._on_offer(new)
            break
        self._asking.pop(name, None)
