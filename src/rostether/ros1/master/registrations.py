"""The registrations of publishers, subscribers, services and watchers: the master's tables, without any I/O.

A node is known while it has registrations. A node that registers with a new URI replaces the old one with all
its registrations; the caller gets both results, and notifies the nodes.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from msgspec import Struct, field

from rostether.errors import GraphError

# A graph of a thousand nodes with a hundred registrations each; only a program that registers in a loop has
# more.
MAX_REGISTRATIONS = 100_000
# Each change of a topic sends the list of its publishers to every subscriber. /rosout has one for each node.
MAX_MEMBERS = 4096
# /rosout has a publisher in each node.
MAX_NODES = MAX_MEMBERS
# When a node leaves, all its registrations are removed at once, in about 15 ms.
MAX_OF_ONE_NODE = 16_384
# A change of a whole namespace is sent to all watchers of its parameters, in about 15 ms. If the watch of a
# roscpp node is refused, the node requests the value each time instead.
MAX_WATCHES = 4096
# Types stay known after their topics, for later requests of tools; at most as many as topics.
MAX_TOPIC_TYPES = MAX_REGISTRATIONS
ANY_TYPE = "*"


class EntryKind(Enum):
    """The kinds of entries in the tables."""

    PUBLISHER = "publisher"
    SUBSCRIBER = "subscriber"
    SERVICE = "service"
    PARAM = "parameter subscriber"


class RegisteredNode(Struct):
    """One node: its name, its XML-RPC URI, and the keys it is registered for, of every kind.

    `keys[EntryKind.SERVICE]` also contains services that another node provides now.
    """

    name: str
    api: str
    keys: dict[EntryKind, dict[str, None]] = field(default_factory=lambda: {kind: {} for kind in EntryKind})

    @property
    def is_empty(self) -> bool:
        """Whether it has no registrations, so that the node can be forgotten."""
        return not any(self.keys.values())


class Removal(Struct, frozen=True):
    """A node that was removed with all its registrations; `topics` have lost a publisher."""

    name: str
    api: str
    topics: tuple[str, ...]


class Registrations:
    """The tables of one master: `{topic, service or parameter: {node name: node URI}}` for each kind."""

    def __init__(self) -> None:
        self.nodes: dict[str, RegisteredNode] = {}
        self.topic_types: dict[str, str] = {}
        self._tables: dict[EntryKind, dict[str, dict[str, str]]] = {kind: {} for kind in EntryKind}
        self._service_apis: dict[str, str] = {}
        self._count = 0
        self._watches = 0

    def keys(self, kind: EntryKind) -> list[str]:
        """Return the topics, services or parameters with registrations, oldest first."""
        return list(self._tables[kind])

    def members(self, kind: EntryKind, key: str) -> dict[str, str]:
        """Return `{node name: node URI}` of those registered for a key; do not change it."""
        return self._tables[kind].get(key, {})

    def apis(self, kind: EntryKind, key: str) -> list[str]:
        """Return the URIs of those registered for a key."""
        return list(self.members(kind, key).values())

    def state(self, kind: EntryKind) -> Iterator[list[str | list[str]]]:
        """Yield one table as in getSystemState: `[key, [node name, ...]]`; it may change meanwhile."""
        for key in self.keys(kind):
            if members := self.members(kind, key):
                yield [key, list(members)]

    def service_api(self, service: str) -> str | None:
        """Return the rosrpc URI of a service."""
        return self._service_apis.get(service)

    def learn_type(self, topic: str, topic_type: str, *, from_publisher: bool) -> None:
        """Record a topic's type; only a publisher's replaces a known one, and `*` replaces none."""
        is_known = topic in self.topic_types
        if topic_type == ANY_TYPE:
            if is_known or not from_publisher:
                return
        elif is_known and not from_publisher:
            return
        if not is_known and len(self.topic_types) >= MAX_TOPIC_TYPES:
            self._forget_oldest_type()
        self.topic_types[topic] = topic_type

    def _forget_oldest_type(self) -> None:
        published = self._tables[EntryKind.PUBLISHER]
        del self.topic_types[next(topic for topic in self.topic_types if topic not in published)]

    def register(self, kind: EntryKind, key: str, name: str, api: str) -> Removal | None:
        """Register a node; return the old one if it had another URI. Raises GraphError at a limit."""
        node = self.nodes.get(name)
        if name not in self.members(kind, key):
            self._check_room(kind, key, node)
        replaced = None
        if node is not None and node.api != api:
            replaced = self.drop(name)
            node = None
        if node is None:
            node = self.nodes[name] = RegisteredNode(name, api)
        node.keys[kind][key] = None
        members = self._tables[kind].setdefault(key, {})
        if name not in members:
            self._count += 1
            self._watches += kind is EntryKind.PARAM
        members[name] = api
        return replaced

    def _check_room(self, kind: EntryKind, key: str, node: RegisteredNode | None) -> None:
        if node is None and len(self.nodes) >= MAX_NODES:
            raise GraphError(f"the master has {MAX_NODES} nodes, its limit; stop some")
        if self._count >= MAX_REGISTRATIONS:
            raise GraphError(f"the master has {self._count} registrations, its limit; unregister some")
        if len(self.members(kind, key)) >= MAX_MEMBERS:
            raise GraphError(f"{key} has {MAX_MEMBERS} nodes registered, the limit; unregister some")
        if kind is EntryKind.PARAM and self._watches >= MAX_WATCHES:
            raise GraphError(f"{MAX_WATCHES} parameters are watched, the limit; read them with getParam")
        if node is not None and sum(map(len, node.keys.values())) >= MAX_OF_ONE_NODE:
            raise GraphError(f"{node.name} has {MAX_OF_ONE_NODE} registrations, the limit; unregister some")

    def register_service(self, service: str, name: str, api: str, service_api: str) -> Removal | None:
        """Register a node as the one provider of a service; see `register`."""
        replaced = self.register(EntryKind.SERVICE, service, name, api)
        members = self._tables[EntryKind.SERVICE][service]
        self._count -= len(members) - 1
        self._tables[EntryKind.SERVICE][service] = {name: api}
        self._service_apis[service] = service_api
        return replaced

    def unregister(self, kind: EntryKind, key: str, name: str, api: str) -> bool:
        """Unregister a node; return False if it was not registered with this URI."""
        node = self.nodes.get(name)
        if node is None or self.members(kind, key).get(name) != api:
            return False
        self._remove(kind, key, node)
        return True

    def unregister_service(self, service: str, name: str, service_api: str) -> bool:
        """Unregister a provider; return False if it is not the current one of the service."""
        node = self.nodes.get(name)
        if node is None:
            return False
        is_current = (
            name in self.members(EntryKind.SERVICE, service)
            and self._service_apis.get(service) == service_api
        )
        if is_current:
            self._remove(EntryKind.SERVICE, service, node)
        elif name not in self.members(EntryKind.SERVICE, service):
            node.keys[EntryKind.SERVICE].pop(service, None)
            self._forget_if_empty(node)
        return is_current

    def drop(self, name: str) -> Removal:
        """Remove a node with all its registrations."""
        node = self.nodes[name]
        topics = tuple(node.keys[EntryKind.PUBLISHER])
        for kind, keys in node.keys.items():
            for key in list(keys):
                if name in self.members(kind, key):
                    self._remove(kind, key, node)
        self.nodes.pop(name, None)
        return Removal(name, node.api, topics)

    def _remove(self, kind: EntryKind, key: str, node: RegisteredNode) -> None:
        table = self._tables[kind]
        del table[key][node.name]
        self._count -= 1
        self._watches -= kind is EntryKind.PARAM
        if not table[key]:
            del table[key]
            if kind is EntryKind.SERVICE:
                del self._service_apis[key]
        del node.keys[kind][key]
        self._forget_if_empty(node)

    def _forget_if_empty(self, node: RegisteredNode) -> None:
        if node.is_empty:
            self.nodes.pop(node.name, None)
