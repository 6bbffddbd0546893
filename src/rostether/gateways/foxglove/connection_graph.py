"""The publishers, subscribers and servers, as differences from what clients received before."""

from __future__ import annotations

from typing import Any, TypeAlias

from rostether.graph.ports import Snapshot

Table: TypeAlias = dict[str, tuple[str, ...]]


class ConnectionGraph:
    """The connection graph as it was last sent to the clients."""

    def __init__(self) -> None:
        self._published: Table = {}
        self._subscribed: Table = {}
        self._offered: Table = {}

    def update(self, snapshot: Snapshot) -> dict[str, Any] | None:
        """Return what is new for those who know the rest; None when nothing is."""
        published = {each.name: each.publishers for each in snapshot.topics.values() if each.publishers}
        subscribed = {each.name: each.subscribers for each in snapshot.topics.values() if each.subscribers}
        offered = {each.name: each.providers for each in snapshot.services.values() if each.providers}
        changes = _changes(
            _new(self._published, published),
            _new(self._subscribed, subscribed),
            _new(self._offered, offered),
            # A topic counts as removed on both sides; what one side still has follows in the same message.
            sorted((self._published.keys() | self._subscribed.keys()) - published.keys() - subscribed.keys()),
            sorted(self._offered.keys() - offered.keys()),
        )
        # A topic that has lost one side only has nobody there.
        changes["publishedTopics"] += _emptied(self._published, published, subscribed, "publisherIds")
        changes["subscribedTopics"] += _emptied(self._subscribed, subscribed, published, "subscriberIds")
        self._published, self._subscribed, self._offered = published, subscribed, offered
        return changes if any(changes.values()) else None

    def whole(self) -> dict[str, Any]:
        """Return everything, for who knows nothing yet."""
        return _changes(self._published, self._subscribed, self._offered, [], [])


def _new(before: Table, now: Table) -> Table:
    return {name: nodes for name, nodes in now.items() if before.get(name) != nodes}


def _emptied(before: Table, now: Table, other_side: Table, key: str) -> list[dict[str, Any]]:
    return [{"name": name, key: []} for name in sorted(before.keys() - now.keys()) if name in other_side]


def _changes(
    published: Table,
    subscribed: Table,
    offered: Table,
    removed_topics: list[str],
    removed_services: list[str],
) -> dict[str, Any]:
    return {
        "publishedTopics": [{"name": name, "publisherIds": list(nodes)} for name, nodes in published.items()],
        "subscribedTopics": [
            {"name": name, "subscriberIds": list(nodes)} for name, nodes in subscribed.items()
        ],
        "advertisedServices": [{"name": name, "providerIds": list(nodes)} for name, nodes in offered.items()],
        "removedTopics": removed_topics,
        "removedServices": removed_services,
    }
