"""Quality of service: the offers of publishers and the requests of subscribers."""

from __future__ import annotations

from enum import IntEnum

from msgspec import Struct


class Reliability(IntEnum):
    """Whether lost messages are sent again; the numbers are rmw's."""

    RELIABLE = 1
    BEST_EFFORT = 2


class Durability(IntEnum):
    """Whether later subscribers get earlier messages; the numbers are rmw's."""

    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class History(IntEnum):
    """How many messages wait for a slow reader; the numbers are rmw's."""

    KEEP_LAST = 1
    KEEP_ALL = 2


class Qos(Struct, frozen=True):
    """The quality of service of one endpoint; deadline, lifespan and liveliness lease are infinite."""

    reliability: Reliability = Reliability.RELIABLE
    durability: Durability = Durability.VOLATILE
    history: History = History.KEEP_LAST
    depth: int = 10

    @property
    def is_latching(self) -> bool:
        """Whether the publisher is latched, in terms of ROS 1."""
        return self.durability is Durability.TRANSIENT_LOCAL


DEFAULT_QOS = Qos()
LATCHED_QOS = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
# As in rcl: later subscribers receive the last 1000 log messages.
ROSOUT_QOS = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1000)
