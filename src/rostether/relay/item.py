"""A topic, service or action to relay from one side to the other."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from rostether.relay.side import RelaySide


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
