"""The current graph according to liveliness tokens, with listeners for changes."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Sequence

from rostether.graph.callbacks import call_safely
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.graph.snapshots import ChangeSignal
from rostether.msgdef.interface import ANY_TYPE
from rostether.ros2.naming import type_of_dds_name
from rostether.ros2.zenoh.tokens import Token, TokenKind, parse_token

# A fleet of a hundred robots with a thousand endpoints each; endpoints over this limit are not listed.
MAX_TOKENS = 100_000

_log = logging.getLogger("rostether.ros2")

_TOPICS = (TokenKind.PUBLISHER, TokenKind.SUBSCRIBER)
EndpointKey = tuple[TokenKind, str]


class GraphCache:
    """The tokens of one domain, and the graph that they announce."""

    def __init__(self) -> None:
        self._tokens: dict[str, Token] = {}
        self._endpoints: dict[EndpointKey, dict[str, Token]] = {}
        self._listeners: dict[EndpointKey, list[Callable[[], None]]] = {}
        self.changed = ChangeSignal()
        self._snapshot: Snapshot | None = None
        # The parts of the last snapshot that are still valid; a change affects only a few of thousands.
        self._node_names: Counter[str] = Counter()
        self._topic_entries: dict[str, TopicEntry] = {}
        self._service_entries: dict[str, ServiceEntry] = {}
        self._problem = ""

    def apply_tokens(self, updates: Sequence[tuple[str, bool]]) -> None:
        """Apply changes: key expressions of tokens, each with True if the token is new, False if removed."""
        touched: dict[EndpointKey, None] = {}
        for text, is_there in updates:
            token = self._add(text) if is_there else self._tokens.pop(text, None)
            if token is None:
                continue
            self._snapshot = None
            self._count_node(token.node_name, 1 if is_there else -1)
            key = (token.kind, token.name)
            self._entries_of(token.kind).pop(token.name, None)
            if is_there:
                self._endpoints.setdefault(key, {})[text] = token
            else:
                self._forget(key, text)
            touched[key] = None
        if not touched:
            return
        self.changed.notify()
        for key in touched:
            for listener in list(self._listeners.get(key, ())):
                call_safely(f"listener of {key[1]}", listener)

    def set_problem(self, problem: str) -> None:
        """Set the reason why the graph is incomplete, for the snapshots; empty if it is complete."""
        if problem != self._problem:
            self._problem = problem
            self._snapshot = None
            self.changed.notify()

    def endpoints(self, kind: TokenKind, name: str) -> list[Token]:
        """Return the tokens of a topic's or service's endpoints of one kind."""
        return list(self._endpoints.get((kind, name), {}).values())

    def all_endpoints(self) -> list[tuple[str, Token]]:
        """Return every endpoint's key expression and token."""
        return [(text, token) for text, token in self._tokens.items() if token.kind is not TokenKind.NODE]

    def listen(self, kind: TokenKind, name: str, listener: Callable[[], None]) -> None:
        """Call back after each change of a topic's or service's endpoints of one kind, until `unlisten`."""
        self._listeners.setdefault((kind, name), []).append(listener)

    def unlisten(self, kind: TokenKind, name: str, listener: Callable[[], None]) -> None:
        """Stop calling back."""
        listeners = self._listeners.get((kind, name), [])
        if listener in listeners:
            listeners.remove(listener)
        if not listeners:
            self._listeners.pop((kind, name), None)

    def snapshot(self) -> Snapshot:
        """Return the whole graph, with the type names of ROS 2; spaces separate the types of one topic."""
        if self._snapshot is None:
            self._snapshot = self._create_snapshot()
        return self._snapshot

    def _add(self, text: str) -> Token | None:
        if text in self._tokens:
            return None
        if len(self._tokens) >= MAX_TOKENS:
            _log.debug("the graph has more than %d endpoints: %s is not listed", MAX_TOKENS, text)
            return None
        token = parse_token(text)
        if token is not None:
            self._tokens[text] = token
        return token

    def _forget(self, key: EndpointKey, text: str) -> None:
        endpoints = self._endpoints.get(key, {})
        endpoints.pop(text, None)
        if not endpoints:
            self._endpoints.pop(key, None)

    def _count_node(self, name: str, change: int) -> None:
        self._node_names[name] += change
        if not self._node_names[name]:
            del self._node_names[name]

    def _entries_of(self, kind: TokenKind) -> dict[str, TopicEntry] | dict[str, ServiceEntry]:
        return self._topic_entries if kind in _TOPICS else self._service_entries

    def _create_snapshot(self) -> Snapshot:
        topics = sorted({name for kind, name in self._endpoints if kind in _TOPICS})
        services = sorted(name for kind, name in self._endpoints if kind is TokenKind.SERVER)
        return Snapshot(
            nodes=tuple(sorted(self._node_names)),
            topics={name: self._topic_entries.get(name) or self._topic_entry(name) for name in topics},
            services={
                name: self._service_entries.get(name) or self._service_entry(name) for name in services
            },
            problem=self._problem,
        )

    def _topic_entry(self, name: str) -> TopicEntry:
        entry = self._topic_entries[name] = TopicEntry(
            name,
            self._types(_TOPICS, name),
            self._nodes(TokenKind.PUBLISHER, name),
            self._nodes(TokenKind.SUBSCRIBER, name),
        )
        return entry

    def _service_entry(self, name: str) -> ServiceEntry:
        entry = self._service_entries[name] = ServiceEntry(
            name, self._nodes(TokenKind.SERVER, name), self._types((TokenKind.SERVER,), name)
        )
        return entry

    def _types(self, kinds: Sequence[TokenKind], name: str) -> str:
        types = {
            type_of_dds_name(token.type) or token.type
            for kind in kinds
            for token in self._endpoints.get((kind, name), {}).values()
        }
        return " ".join(sorted(types)) or ANY_TYPE

    def _nodes(self, kind: TokenKind, name: str) -> tuple[str, ...]:
        return tuple(sorted({token.node_name for token in self._endpoints.get((kind, name), {}).values()}))
