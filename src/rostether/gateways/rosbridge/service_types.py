"""The types of services: clients call services only by name, and a ROS 1 master does not know the types."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeAlias

from rostether.errors import ServiceUnavailableError
from rostether.gateways.type_names import short_type
from rostether.graph.ports import Graph
from rostether.msgdef.interface import ANY_TYPE, ServiceType
from rostether.serde.store import TypeStore

# Takes a service's name, asks its server, and returns the service's type or the server's host. Raises
# RostetherError.
AskServer: TypeAlias = Callable[[str], Awaitable[str]]

# A page that calls often asks the server once; a new type after a restart is seen soon.
_REMEMBERED_S = 5.0

# The limit of cached names, because they come from clients.
_MAX_REMEMBERED = 1000


class ServiceTypes:
    """The types of the graph's services, cached for a short time."""

    def __init__(self, graph: Graph, store: TypeStore, ask_server: AskServer | None = None) -> None:
        self._graph = graph
        self._store = store
        self._ask_server = ask_server
        self._known: dict[str, tuple[float, ServiceType]] = {}

    async def find(self, service: str) -> ServiceType:
        """Return the type of a service. Raises ServiceUnavailableError, UnknownTypeError, DefinitionError."""
        now_s = asyncio.get_running_loop().time()
        found = self._known.get(service)
        if found is not None and now_s - found[0] < _REMEMBERED_S:
            return found[1]
        service_type = self._store.registry.service_type(short_type(await self._name(service)))
        self.forget(service)
        if len(self._known) >= _MAX_REMEMBERED:
            del self._known[next(iter(self._known))]
        self._known[service] = (now_s, service_type)
        return service_type

    def forget(self, service: str) -> None:
        """Forget a type after a failed call."""
        self._known.pop(service, None)

    async def _name(self, service: str) -> str:
        listed = (await self._graph.snapshot()).services.get(service)
        if listed is None:
            raise ServiceUnavailableError(f"service {service} does not exist; check that its node is running")
        if listed.type != ANY_TYPE:
            return listed.type
        if self._ask_server is None:
            raise ServiceUnavailableError(
                f"the type of service {service} is unknown, because the graph does not report it; "
                "check that its node is running"
            )
        return await self._ask_server(service)
