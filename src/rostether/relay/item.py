"""What a relay relays: its two graphs, the filter of names and directions, and the chosen items."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from enum import Enum
from fnmatch import fnmatchcase
from typing import NamedTuple

from msgspec import Struct

from rostether.errors import DefinitionError
from rostether.graph.ports import Graph
from rostether.msgdef.interface import ANY_TYPE, ServiceType
from rostether.names.graph_name import NODE_SERVICES

# Each graph has its own topics with these names: they are relayed only if given without `*`.
PRIVATE_TOPICS = frozenset({"/rosout", "/rosout_agg", "/parameter_events", "/clock"})

# The topics of an action in ROS 1. In ROS 2, its topics and services are below `_action`.
ACTION_TOPICS = ("goal", "cancel", "feedback", "result", "status")

# Returns the type of a service, by the service's name and the type's name (`*` if it is unknown). Raises
# RostetherError.
FindServiceType = Callable[[str, str], Awaitable[ServiceType]]

# Returns whether the node with a name was killed; if so, removes its registrations. Raises RostetherError.
ForgetNode = Callable[[str], Awaitable[bool]]


class RelayDirection(Enum):
    """The directions in which a relay copies messages between its two graphs."""

    BOTH = "both"
    FIRST_TO_SECOND = "first to second"
    SECOND_TO_FIRST = "second to first"


class TopicFilter(Struct, frozen=True):
    """Topics that match a pattern, in one direction or both."""

    pattern: str
    direction: RelayDirection = RelayDirection.BOTH

    def covers(self, name: str, direction: RelayDirection) -> bool:
        """Return whether a topic is relayed in a direction."""
        if self.direction not in (RelayDirection.BOTH, direction):
            return False
        if name in PRIVATE_TOPICS or "/_action/" in name:
            return name == self.pattern
        return fnmatchcase(name, self.pattern)


class ServiceFilter(Struct, frozen=True):
    """Services that match a pattern; `type` is needed if the graph does not know it."""

    pattern: str
    type: str = ""

    def covers(self, name: str) -> bool:
        """Return whether a service is relayed to the graph that does not have it.

        The services that every node offers about itself are relayed only if given without `*`.
        """
        if name.rpartition("/")[2] in NODE_SERVICES or "/_action/" in name:
            return name == self.pattern
        return fnmatchcase(name, self.pattern)


class RelayFilter(Struct, frozen=True):
    """Everything that a relay relays; `actions` are patterns."""

    topics: tuple[TopicFilter, ...] = ()
    services: tuple[ServiceFilter, ...] = ()
    actions: tuple[str, ...] = ()

    def relays_topic(self, name: str, direction: RelayDirection) -> bool:
        """Return whether a topic is relayed in a direction; those of a relayed action are not."""
        action, _, part = name.rpartition("/")
        if part in ACTION_TOPICS and self.relays_action(action):
            return False
        return any(each.covers(name, direction) for each in self.topics)

    def relays_action(self, name: str) -> bool:
        """Return whether an action is relayed to the graph that does not have it."""
        return any(fnmatchcase(name, pattern) for pattern in self.actions)

    def service(self, name: str) -> ServiceFilter | None:
        """Return the first entry that covers a service, None if it is not relayed."""
        return next((each for each in self.services if each.covers(name)), None)


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


class ItemKind(Enum):
    """The kind of an item; reports about it start with the value."""

    TOPIC = ""
    SERVICE = "service "
    ACTION = "action "


class RelayItem(NamedTuple):
    """A topic, service or action to relay.

    `chosen_type` is the type of an action, or of a service whose graph does not report the type; else empty.
    """

    kind: ItemKind
    name: str
    source: RelaySide
    target: RelaySide
    chosen_type: str = ""

    @property
    def text(self) -> str:
        """The item's description for users."""
        return f"{self.kind.value}{self.name} from {self.source.name} to {self.target.name}"
