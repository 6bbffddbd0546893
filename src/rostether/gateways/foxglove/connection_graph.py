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

Table: TypeAlias = dict[str, tuple[str, ...]]
FindType: TypeAlias = Callable[[str], MessageType | None]


class ConnectionGraph:
    """The connection graph as it was last sent to the clients.

    `find_type` returns the type of a name, None if its definition is not known.
    """

    def __init__(self, find_type: FindType) -> None:
        self._find_type = find_type
        self._published: Table = {}
        self._subscribed: Table = {}
        self._types: dict[str, str] = {}
        self._offered: Table = {}

    def update(self, snapshot: Snapshot) -> dict[str, Any] | None:
        """Return the changes since the last update, None if there are none."""
        published = {each.name: each.publishers for each in snapshot.topics.values() if each.publishers}
        subscribed = {each.name: each.subscribers for each in snapshot.topics.values() if each.subscribers}
        offered = {each.name: each.providers for each in snapshot.services.values() if each.providers}
        types = {name: snapshot.topics[name].type for name in subscribed if name not in published}
        newly_typed = {
            name: nodes for name, nodes in subscribed.items() if types.get(name) != self._types.get(name)
        }
        self._types = types
        changes = self._changes(
            _new(self._published, published),
            newly_typed | _new(self._subscribed, subscribed),
            _new(self._offered, offered),
            # A topic is removed on both sides; the same message lists again what one side still has.
            sorted((self._published.keys() | self._subscribed.keys()) - published.keys() - subscribed.keys()),
            sorted(self._offered.keys() - offered.keys()),
        )
        # A topic that has lost one side gets an empty list there.
        changes["publishedTopics"] += _emptied(self._published, published, subscribed, "publisherIds")
        changes["subscribedTopics"] += _emptied(self._subscribed, subscribed, published, "subscriberIds")
        self._published, self._subscribed, self._offered = published, subscribed, offered
        return changes if any(changes.values()) else None

    def whole(self) -> dict[str, Any]:
        """Return the whole graph, for a new client."""
        return self._changes(self._published, self._subscribed, self._offered, [], [])

    def _changes(
        self,
        published: Table,
        subscribed: Table,
        offered: Table,
        removed_topics: list[str],
        removed_services: list[str],
    ) -> dict[str, Any]:
        return {
            "publishedTopics": [
                {"name": name, "publisherIds": list(nodes)} for name, nodes in published.items()
            ],
            "subscribedTopics": [
                {"name": name, "subscriberIds": list(nodes), **self._schema(name)}
                for name, nodes in subscribed.items()
            ],
            "advertisedServices": [
                {"name": name, "providerIds": list(nodes)} for name, nodes in offered.items()
            ],
            "removedTopics": removed_topics,
            "removedServices": removed_services,
        }

    def _schema(self, topic: str) -> dict[str, str]:
        message_type = self._find_type(self._types[topic]) if topic in self._types else None
        return {"schemaName": message_type.name, "schema": message_type.definition} if message_type else {}


def _new(before: Table, now: Table) -> Table:
    return {name: nodes for name, nodes in now.items() if before.get(name) != nodes}


def _emptied(before: Table, now: Table, other_side: Table, key: str) -> list[dict[str, Any]]:
    return [{"name": name, key: []} for name in sorted(before.keys() - now.keys()) if name in other_side]
