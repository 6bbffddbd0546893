"""The shared state of the nodes of one zenoh session, and their liveliness tokens."""

from __future__ import annotations

import asyncio
import itertools
import logging
from concurrent.futures import ThreadPoolExecutor

import zenoh
from msgspec.structs import replace

from rostether.graph.ports import Report
from rostether.names.graph_name import namespace_of
from rostether.ros2.naming import dds_name
from rostether.ros2.parameters.ros2_membership import Ros2Membership
from rostether.ros2.types.type_support import MessageSupport, Ros2Types, ServiceSupport
from rostether.ros2.zenoh.graph_cache import GraphCache
from rostether.ros2.zenoh.qos import DEFAULT_QOS, Qos
from rostether.ros2.zenoh.tokens import Token, TokenKind, data_key

# Each puts a batch while a link is full. More threads would only wait for the same few links.
MAX_PUT_THREADS = 8

# Each waits for room for a service request or response, at most 5 s: then zenoh closes the full link.
MAX_CALL_THREADS = 8

_log = logging.getLogger("rostether.ros2")


class SharedSession:
    """The part of a session that its nodes use."""

    def __init__(self, session: zenoh.Session, domain_id: int, types: Ros2Types) -> None:
        self.zenoh = session
        self.domain_id = domain_id
        self.types = types
        self.graph = GraphCache()
        self.session_id = str(session.zid())
        self.liveliness = session.liveliness()
        # No thread starts before the first publication finds a full link.
        self.put_threads = ThreadPoolExecutor(MAX_PUT_THREADS, "zenoh put")
        # A separate pool: a caller that hangs must not block the loop or a topic.
        self.call_threads = ThreadPoolExecutor(MAX_CALL_THREADS, "zenoh call")
        self.nodes: set[Ros2Membership] = set()
        self._ids = itertools.count()

    def next_id(self) -> int:
        """Return an id that no other entity of this session has."""
        return next(self._ids)

    async def query_tokens(self, key: str, timeout_s: float) -> list[str]:
        """Return the key expressions of the tokens that match a key expression; wait at most `timeout_s`."""
        loop = asyncio.get_running_loop()
        found: list[str] = []
        done = asyncio.Event()

        def finish() -> None:
            try:
                loop.call_soon_threadsafe(done.set)
            except RuntimeError:
                _log.debug("an answer came after the loop had ended")

        def on_reply(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                found.append(str(reply.ok.key_expr))

        self.liveliness.get(key, zenoh.handlers.Callback(on_reply, finish, indirect=False), timeout=timeout_s)
        await done.wait()
        return found


class LiveToken:
    """A token of this session, alive until `withdraw`."""

    def __init__(self, session: SharedSession, token: Token) -> None:
        self.text = token.format()
        self._session = session
        self._declared = session.liveliness.declare_token(self.text)
        # The session ignores its own tokens from zenoh.
        session.graph.apply_tokens([(self.text, True)])

    def withdraw(self) -> None:
        """Withdraw the token. Call it once."""
        self._declared.undeclare()
        self._session.graph.apply_tokens([(self.text, False)])


class NodeEntities:
    """Declares the tokens of one node: one for the node, and one for each of its endpoints.

    `report` logs a line about the node.
    """

    def __init__(self, session: SharedSession, node_name: str, report: Report) -> None:
        self.session = session
        self.report = report
        node_id = session.next_id()
        self._token = Token(
            session.domain_id,
            session.session_id,
            node_id,
            node_id,
            TokenKind.NODE,
            namespace_of(node_name),
            node_name.rpartition("/")[2],
        )

    def declare_node(self) -> LiveToken:
        """Announce the node."""
        return LiveToken(self.session, self._token)

    def declare(
        self, kind: TokenKind, name: str, support: MessageSupport | ServiceSupport, qos: Qos = DEFAULT_QOS
    ) -> LiveToken:
        """Announce an endpoint of a topic or service."""
        token = replace(
            self._token,
            entity_id=self.session.next_id(),
            kind=kind,
            name=name,
            type=dds_name(support.name),
            type_hash=support.type_hash,
            qos=qos,
        )
        return LiveToken(self.session, token)

    def key(self, name: str, support: MessageSupport | ServiceSupport) -> str:
        """Return the key expression of a topic's samples or of a service's queries."""
        return data_key(self.session.domain_id, name, dds_name(support.name), support.type_hash)
