"""The liveliness tokens of a node: one for the node, and one for each of its endpoints."""

from __future__ import annotations

from rostether.names.graph_name import namespace_of
from rostether.ros2.qos import DEFAULT_QOS, Qos
from rostether.ros2.zenoh.shared_session import LiveToken, SharedSession
from rostether.ros2.zenoh.tokens import Token, TokenKind


class NodeEntities:
    """Declares the tokens of one node."""

    def __init__(self, session: SharedSession, node_name: str) -> None:
        self.session = session
        self.node_name = node_name
        self._namespace = namespace_of(node_name)
        self._base_name = node_name.rpartition("/")[2]
        self._id = session.next_id()

    def declare_node(self) -> LiveToken:
        """Announce the node."""
        return self._declare(TokenKind.NODE, self._id)

    def declare(
        self, kind: TokenKind, name: str, dds_type: str, type_hash: str, qos: Qos = DEFAULT_QOS
    ) -> LiveToken:
        """Announce an endpoint of a topic or service."""
        return self._declare(kind, self.session.next_id(), name, dds_type, type_hash, qos)

    def _declare(
        self,
        kind: TokenKind,
        entity_id: int,
        name: str = "",
        dds_type: str = "",
        type_hash: str = "",
        qos: Qos = DEFAULT_QOS,
    ) -> LiveToken:
        session = self.session
        return LiveToken(
            session,
            Token(
                session.domain_id,
                session.session_id,
                self._id,
                entity_id,
                kind,
                self._namespace,
                self._base_name,
                name,
                dds_type,
                type_hash,
                qos,
            ),
        )
