"""The notifications of changes from a master to nodes, in their order; without any I/O."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

from rostether.ros1.master.registrations import EntryKind, Registrations
from rostether.xmlrpc.values import XmlRpcValue


class NodeCalls(Protocol):
    """How the master calls nodes: each call is queued for the node's URI, and the caller does not wait."""

    def publisher_update(self, api: str, topic: str, publishers: list[str]) -> None:
        """Send a subscriber the URIs of the topic's publishers."""

    def param_update(self, api: str, key: str, value: XmlRpcValue) -> None:
        """Send a watcher the new value of a parameter."""

    def ping(self, api: str) -> None:
        """Check whether a node answers, and continue to check it."""

    def shut_down(self, api: str, reason: str) -> None:
        """Ask a node to shut down, and forget all other calls to it."""


class TopicNotices:
    """Notifies subscribers of the publishers of their topics; `work_later` runs the steps of long work."""

    def __init__(
        self,
        registrations: Registrations,
        node_calls: NodeCalls,
        work_later: Callable[[Iterator[None]], None],
    ) -> None:
        self._registrations = registrations
        self._node_calls = node_calls
        self._work_later = work_later
        self._changed: dict[str, None] = {}

    def send(self, topic: str) -> None:
        """Notify a topic's subscribers now."""
        publishers = self._registrations.apis(EntryKind.PUBLISHER, topic)
        for api in self._registrations.apis(EntryKind.SUBSCRIBER, topic):
            self._node_calls.publisher_update(api, topic, publishers)

    def send_later(self, topics: Iterable[str]) -> None:
        """Notify the subscribers of many topics in slices: each receives the current publishers."""
        is_working = bool(self._changed)
        self._changed.update(
            dict.fromkeys(
                topic for topic in topics if self._registrations.members(EntryKind.SUBSCRIBER, topic)
            )
        )
        if self._changed and not is_working:
            self._work_later(self._steps())

    def _steps(self) -> Iterator[None]:
        while self._changed:
            topic = next(iter(self._changed))
            self.send(topic)
            del self._changed[topic]
            yield
