"""The filter of a relay: names of topics and services, with `*` as a wildcard, and directions."""

from __future__ import annotations

from enum import Enum
from fnmatch import fnmatchcase

from msgspec import Struct

from rostether.names.graph_name import NODE_SERVICES

# Each graph has its own topics with these names: they are relayed only if given without `*`.
PRIVATE_TOPICS = frozenset({"/rosout", "/rosout_agg", "/parameter_events", "/clock"})

# The topics of an action in ROS 1. In ROS 2, its topics and services are below `_action`.
ACTION_TOPICS = ("goal", "cancel", "feedback", "result", "status")


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
