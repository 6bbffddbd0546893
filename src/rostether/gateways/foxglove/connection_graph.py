"""The publishers, subscribers and servers of a graph, as changes since the last update.

A topic that has subscribers but no publisher is not a channel. The fields `schemaName` and `schema` of its
entry contain its type, so that a page can publish commands for a board. The protocol does not define these
fields; other clients ignore them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from rostether.graph.ports import Snapshot
from rostether.msgdef.interface import MessageType

FindType: TypeAlias = Callable[[str], MessageType | None]
# By name: the nodes, and the type to describe; empty without one.
_Table: TypeAlias = dict[str, tuple[tuple[str, ...], str]]

_PUBLISHED, _SUBSCRIBED, _OFFERED = "publishedTopics", "subscribedTopics", "advertisedServices"
_NODES = {_PUBLISHED: "publisherIds", _SUBSCRIBED: "subscriberIds", _OFFERED: "providerIds"}


class ConnectionGraph:
    """The connection graph as it was last sent to the clients.

    `find_type` returns the type of a name, None if its definition is not known.
    """

    def __init__(self, find_type: FindType) -> None:
        self._find_type = find_type
        self._tables: dict[str, _Table] = {key: {} for key in _NODES}

    def update(self, snapshot: Snapshot) -> dict[str, Any] | None:
        """Return the changes since the last update, None if there are none."""
        topics, services = snapshot.topics.values(), snapshot.services.values()
        before = self._tables
        now: dict[str, _Table] = {
            _PUBLISHED: {each.name: (each.publishers, "") for each in topics if each.publishers},
            _SUBSCRIBED: {
                each.name: (each.subscribers, "" if each.publishers else each.type)
                for each in topics
                if each.subscribers
            },
            _OFFERED: {each.name: (each.providers, "") for each in services if each.providers},
        }
        self._tables = now
        changes = {
            key: [
                self._entry(key, name, *each) for name, each in table.items() if before[key].get(name) != each
            ]
            for key, table in now.items()
        }
        known = now[_PUBLISHED].keys() | now[_SUBSCRIBED].keys()
        # A topic that has lost one side gets an empty list there. It is removed when both sides have ended.
        for key in (_PUBLISHED, _SUBSCRIBED):
            lost = sorted(before[key].keys() - now[key].keys())
            changes[key] += [self._entry(key, name, (), "") for name in lost if name in known]
        removed: dict[str, Any] = {
            "removedTopics": sorted((before[_PUBLISHED].keys() | before[_SUBSCRIBED].keys()) - known),
            "removedServices": sorted(before[_OFFERED].keys() - now[_OFFERED].keys()),
        }
        changes |= removed
        return changes if any(changes.values()) else None

    def whole(self) -> dict[str, Any]:
        """Return the whole graph, for a new client."""
        entries = {
            key: [self._entry(key, name, *each) for name, each in table.items()]
            for key, table in self._tables.items()
        }
        return {**entries, "removedTopics": [], "removedServices": []}

    def _entry(self, key: str, name: str, nodes: tuple[str, ...], type_name: str) -> dict[str, Any]:
        entry: dict[str, Any] = {"name": name, _NODES[key]: list(nodes)}
        if type_name and (found := self._find_type(type_name)) is not None:
            entry |= {"schemaName": found.name, "schema": found.definition}
        return entry
