"""The endpoints of a graph over zenoh in detail, from their liveliness tokens."""

from __future__ import annotations

from collections.abc import Iterable

from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.naming import type_of_dds_name
from rostether.ros2.zenoh.attachment import gid_of
from rostether.ros2.zenoh.tokens import Kind, Token

_KINDS = {
    Kind.PUBLISHER: EndpointKind.PUBLISHER,
    Kind.SUBSCRIBER: EndpointKind.SUBSCRIPTION,
    Kind.SERVER: EndpointKind.SERVER,
    Kind.CLIENT: EndpointKind.CLIENT,
}


def list_endpoints(tokens: Iterable[tuple[str, Token]]) -> list[EndpointInfo]:
    """Return what tokens, each with its text, say; nodes are no ends."""
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
