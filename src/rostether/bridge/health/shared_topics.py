"""Reports topics and services that several boards have: each of several equal boards needs a namespace."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from typing import Final

from rostether.bridge.board_registry import Board
from rostether.bridge.endpoint.openings import Role, name_of
from rostether.bridge.reporter import Reporter
from rostether.graph.ports import Level
from rostether.rosserial.events import ServiceRole, TopicRole

# Topics on which many nodes publish by convention.
_COMMON: Final = frozenset({"/tf", "/tf_static", "/rosout", "/diagnostics", "/joint_states"})

# More would not fit on one line.
_SHOWN: Final = 4

# Boards choose the names: a hostile one must not fill the memory.
_MAX_REPORTED: Final = 1000

# The roles in which boards disturb each other; several may call one service.
_VERBS: Final[dict[Role, str]] = {
    TopicRole.PUBLISHER: "publish",
    TopicRole.SUBSCRIBER: "subscribe to",
    ServiceRole.SERVER: "offer",
}


class SharedTopics:
    """Reports topics and services that several boards have: equal boards need namespaces."""

    def __init__(self, reporter: Reporter) -> None:
        self._reporter = reporter
        self._seen: list[tuple[str, int]] = []
        self._reported: set[tuple[Role, str]] = set()

    def check(self, boards: Iterable[Board]) -> None:
        """Report topics and services that several connected boards have in the same role."""
        nodes = [
            board.node
            for board in boards
            if board.node is not None and board.session is not None and board.session.is_connected
        ]
        seen = [(node.graph.node_name, len(list(node.endpoints))) for node in nodes]
        if seen == self._seen:
            return
        self._seen = seen
        users: defaultdict[tuple[Role, str], list[str]] = defaultdict(list)
        for node in nodes:
            for role, endpoint in node.endpoints:
                users[role, node.graph.resolve(name_of(endpoint))].append(node.graph.node_name)
        for role in _VERBS:
            self._report(role, {key: names for key, names in users.items() if key[0] is role})

    def _report(self, role: Role, users: dict[tuple[Role, str], list[str]]) -> None:
        new = [
            key
            for key, names in users.items()
            if len(names) > 1 and key[1] not in _COMMON and key not in self._reported
        ]
        if not new or len(self._reported) >= _MAX_REPORTED:
            return
        self._reported.update(new)
        shown = _shown([name for _, name in new])
        # Subscribers get the messages of all boards, but a caller gets the answer of one.
        level, noun = (Level.WARN, "services") if role is ServiceRole.SERVER else (Level.INFO, "topics")
        self._reporter.report(
            level,
            f"{_shown(users[new[0]])} {_VERBS[role]} {shown}; --ns-per-board gives each board its own {noun}",
        )


def _shown(names: list[str]) -> str:
    """Return names as text: `/a, /b and 3 more`."""
    shown = names[:_SHOWN] if len(names) > _SHOWN + 1 else names
    if len(shown) < len(names):
        return f"{', '.join(shown)} and {len(names) - len(shown)} more"
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
