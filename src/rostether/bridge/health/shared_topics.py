"""Reports topics that several boards have: each of several equal boards needs a namespace."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from typing import Final

from rostether.bridge.board_registry import Board
from rostether.bridge.endpoint.openings import name_of
from rostether.bridge.reporter import Reporter
from rostether.graph.ports import Level
from rostether.rosserial.events import TopicRole

# Topics on which many nodes publish by convention.
_COMMON: Final = frozenset({"/tf", "/tf_static", "/rosout", "/diagnostics", "/joint_states"})

# More would not fit on one line.
_SHOWN: Final = 4

# Boards choose the names: a hostile one must not fill the memory.
_MAX_REPORTED: Final = 1000


class SharedTopics:
    """Remembers which topics were reported."""

    def __init__(self, reporter: Reporter) -> None:
        self._reporter = reporter
        self._seen: list[tuple[str, int]] = []
        self._reported: set[tuple[TopicRole, str]] = set()

    def check(self, boards: Iterable[Board]) -> None:
        """Report topics that several connected boards publish, or to which several subscribe."""
        nodes = [
            board.node
            for board in boards
            if board.node is not None and board.session is not None and board.session.is_connected
        ]
        seen = [(node.graph.node_name, len(node.endpoints.announced_topics())) for node in nodes]
        if seen == self._seen:
            return
        self._seen = seen
        users: defaultdict[tuple[TopicRole, str], list[str]] = defaultdict(list)
        for node in nodes:
            for role, endpoint in node.endpoints:
                if isinstance(role, TopicRole):
                    users[role, node.graph.resolve(name_of(endpoint))].append(node.graph.node_name)
        for role, verb in ((TopicRole.PUBLISHER, "publish"), (TopicRole.SUBSCRIBER, "subscribe to")):
            self._report(verb, {key: names for key, names in users.items() if key[0] is role})

    def _report(self, verb: str, users: dict[tuple[TopicRole, str], list[str]]) -> None:
        new = [
            key
            for key, names in users.items()
            if len(names) > 1 and key[1] not in _COMMON and key not in self._reported
        ]
        if not new or len(self._reported) >= _MAX_REPORTED:
            return
        self._reported.update(new)
        topics = _shown([name for _, name in new])
        self._reporter.report(
            Level.INFO,
            f"{_shown(users[new[0]])} {verb} {topics}; --ns-per-board gives each board its own topics",
        )


def _shown(names: list[str]) -> str:
    """Return names as text: `/a, /b and 3 more`."""
    shown = names[:_SHOWN] if len(names) > _SHOWN + 1 else names
    if len(shown) < len(names):
        return f"{', '.join(shown)} and {len(names) - len(shown)} more"
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
