"""One of the two graphs of a relay."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from msgspec import Struct

from rostether.errors import DefinitionError
from rostether.graph.ports import Graph
from rostether.msgdef.interface import ANY_TYPE, ServiceType

# Returns the type of a service, by the service's name and the type's name (`*` if it is unknown). Raises
# RostetherError.
FindServiceType = Callable[[str, str], Awaitable[ServiceType]]

# Returns whether the node with a name was killed; if so, removes its registrations. Raises RostetherError.
ForgetNode = Callable[[str], Awaitable[bool]]


class RelaySide(Struct, frozen=True):
    """A graph, its name for users, and a function that finds the types of services.

    `forget_if_gone` is for a graph that keeps the registrations of nodes that were killed: ROS 1.
    """

    name: str
    graph: Graph
    service_type: FindServiceType
    forget_if_gone: ForgetNode | None = None

    async def find_service_type(self, service: str, chosen: str) -> ServiceType:
        """Return a service's type: the chosen one, else the graph's. Raises RostetherError."""
        listed = (await self.graph.snapshot()).services.get(service)
        type_name = chosen or (listed.type if listed is not None else ANY_TYPE)
        try:
            return await self.service_type(service, type_name)
        except DefinitionError as error:
            raise DefinitionError(f"{error}; or give it as {service}=package/Type") from None
