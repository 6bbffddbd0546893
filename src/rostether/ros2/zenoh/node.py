"""A node of a ROS 2 graph over zenoh: the graph port by rmw_zenoh's conventions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import AsyncExitStack

from rostether.graph.ports import ParamValue
from rostether.ros2.clock import NodeClock
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.naming import type_of_dds_name
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.services import ParameterServices
from rostether.ros2.parameters.store import ParameterStore
from rostether.ros2.types.type_hash import TYPE_HASH_NOT_SUPPORTED
from rostether.ros2.zenoh.attachment import gid_of
from rostether.ros2.zenoh.endpoint_handles import ZenohEndpoints
from rostether.ros2.zenoh.shared_session import SharedSession
from rostether.ros2.zenoh.tokens import ADMIN_SPACE, Token, TokenKind, parse_token
from rostether.rostime import Time

_KINDS = {
    TokenKind.PUBLISHER: EndpointKind.PUBLISHER,
    TokenKind.SUBSCRIBER: EndpointKind.SUBSCRIPTION,
    TokenKind.SERVER: EndpointKind.SERVER,
    TokenKind.CLIENT: EndpointKind.CLIENT,
}

# A router on this machine answers in milliseconds.
DOMAINS_TIMEOUT_S = 1.0


class ZenohGraph(ZenohEndpoints):
    """Implements `graph.ports.Graph`; made by `ZenohSession.join`."""

    def __init__(
        self,
        session: SharedSession,
        node_name: str,
        namespace: str,
        remappings: Mapping[str, str],
        parameters: Mapping[str, ParamValue],
    ) -> None:
        super().__init__(session, node_name, namespace, remappings)
        store = ParameterStore(parameters)
        self._parameters = GraphParameters(store, self)
        self._parameter_services = ParameterServices(store, self)
        self._clock = NodeClock(store, self)

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return self._clock.now()

    async def endpoints(self) -> list[EndpointInfo]:
        """Return all known endpoints of topics and services."""
        return list_endpoints(self._session.graph.all_endpoints())

    async def distribution(self) -> str:
        """Return "humble" if an endpoint of another session has no type hash, else an empty string."""
        own = self._session.session_id
        tokens = (token for _, token in self._session.graph.all_endpoints() if token.session_id != own)
        is_humble = any(token.type_hash == TYPE_HASH_NOT_SUPPORTED for token in tokens)
        return "humble" if is_humble else ""

    async def other_domains(self) -> list[int]:
        """Return the other domains of this zenoh network that have nodes, sorted."""
        key = f"{ADMIN_SPACE}/*/*/*/*/{TokenKind.NODE.value}/**"
        texts = await self._session.query_tokens(key, DOMAINS_TIMEOUT_S)
        found = {token.domain_id for token in map(parse_token, texts) if token is not None}
        return sorted(found - {self._session.domain_id})

    async def open(self) -> None:
        """Appear in the graph; `ZenohSession.join` calls it. Raises GraphError."""
        self._open_endpoints()
        await self._clock.open()
        await self._parameter_services.open()

    async def _end(self) -> None:
        try:
            async with AsyncExitStack() as stack:
                # The stack closes in reverse order: the users of the endpoints before the endpoints.
                stack.push_async_callback(self._close_endpoints)
                stack.push_async_callback(self._parameter_services.close)
                stack.push_async_callback(self._clock.close)
                stack.push_async_callback(self._parameters.close)
        finally:
            self._session.nodes.discard(self)


def list_endpoints(tokens: Iterable[tuple[str, Token]]) -> list[EndpointInfo]:
    """Return the endpoints of tokens, without tokens of nodes."""
    return [_describe(text, token) for text, token in tokens if token.kind in _KINDS]


def _describe(text: str, token: Token) -> EndpointInfo:
    qos = token.qos
    return EndpointInfo(
        token.node_name,
        _KINDS[token.kind],
        token.name,
        type_of_dds_name(token.type) or token.type,
        token.type_hash,
        gid_of(text),
        QosReport(qos.reliability.name, qos.durability.name, qos.history.name, qos.depth),
    )
