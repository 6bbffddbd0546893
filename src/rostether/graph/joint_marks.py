"""Topics that mark the nodes of programs in two graphs, so that these programs recognize each other.

    /rostether/_relay_<since><id>    a relay: its messages come from its other graph
    /rostether/_joint_<since><id>    a board in both graphs: it publishes all its messages in both

A program has one mark, and each of its nodes advertises it in every graph that the node is in. Nothing is
published there. A node that has the same mark in two graphs is in both. A name alone does not show that:
`/talker` of ROS 1 and `/talker` of ROS 2 are usually two programs.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Iterable

from msgspec import Struct, field

from rostether.graph.ports import Snapshot
from rostether.msgdef.interface import MessageType

MARK_TYPE = MessageType("std_msgs/Empty", "d41d8cd98f00b204e9800998ecf8427e")
_PREFIX = "/rostether/_"
_RELAY, _JOINT = f"{_PREFIX}relay_", f"{_PREFIX}joint_"


def new_relay_mark() -> str:
    """Return the mark of a relay that starts now; marks of older relays sort before it."""
    return _RELAY + _token()


def new_joint_mark() -> str:
    """Return the mark of a program whose boards are in several graphs."""
    return _JOINT + _token()


def is_mark(topic: str) -> bool:
    """Return whether a topic only marks nodes, without messages."""
    return topic.startswith((_RELAY, _JOINT))


def relay_marks(snapshot: Snapshot) -> dict[str, str]:
    """Return the relays in one graph, by name, with their marks."""
    return {
        node: name
        for name, topic in snapshot.topics.items()
        if name.startswith(_RELAY)
        for node in topic.publishers
    }


class MarkedNodes(Struct, frozen=True):
    """Nodes that have the same mark in two or more graphs: `relays` with their marks, and boards."""

    relays: dict[str, str] = field(default_factory=dict)
    joint: frozenset[str] = frozenset()

    @classmethod
    def find(cls, snapshots: Iterable[Snapshot]) -> MarkedNodes:
        """Find the marked nodes in a snapshot of each graph."""
        found = Counter(
            (name, node)
            for snapshot in snapshots
            for name, topic in snapshot.topics.items()
            if is_mark(name)
            for node in topic.publishers
        )
        common = [each for each, count in found.items() if count > 1]
        return cls(
            {node: mark for mark, node in common if mark.startswith(_RELAY)},
            frozenset(node for mark, node in common if mark.startswith(_JOINT)),
        )

    @property
    def names(self) -> set[str]:
        """The names of all marked nodes."""
        return {*self.relays, *self.joint}


def replace_names(names: set[str], new: set[str]) -> None:
    """Change a set that other threads read; unchanged elements are never missing."""
    names |= new
    names &= new


def _token() -> str:
    return f"{time.time_ns():016x}{os.urandom(4).hex()}"
