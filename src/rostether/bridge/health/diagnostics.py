"""The state of each board as values, for lines and tables."""

from __future__ import annotations

from msgspec import Struct

from rostether.bridge.board_node import BoardNode
from rostether.bridge.endpoint.publisher import PublisherEndpoint
from rostether.bridge.session import Session
from rostether.rosserial.events import ServiceAnnounced


class EndpointView(Struct, frozen=True):
    """One endpoint; counts are in messages since it was first announced.

    `dropped_count` were lost to a queue that overflowed, `misfit_count` did not have their type's layout.
    """

    role: str
    name: str
    type: str
    topic_id: int
    buffer_bytes: int
    is_attached: bool
    message_count: int
    dropped_count: int
    misfit_count: int


class BoardView(Struct, frozen=True):
    """One board; link figures are those of the current connection, zero without one."""

    node: str
    peer: str
    is_connected: bool
    is_settled: bool
    protocol_version: int | None
    endpoints: tuple[EndpointView, ...]
    received_bytes: int = 0
    sent_bytes: int = 0
    received_frames: int = 0
    discarded_frames: int = 0
    discarded_bytes: int = 0
    reset_count: int = 0
    queued_bytes: int = 0
    damaged_frames: int = 0
    round_trip_s: float | None = None
    baud: int | None = None
    is_searching: bool = False


def view_board(node: BoardNode, session: Session | None) -> BoardView:
    """Describe a board; `session` is its connection, None while it has none."""
    endpoints = []
    for role, endpoint in node.endpoints:
        info = endpoint.info
        if isinstance(info, ServiceAnnounced):
            name, type_name, topic = info.name, info.type, info.request
        else:
            name, type_name, topic = info.topic_name, info.message_type, info
        lost = endpoint.lost_count if isinstance(endpoint, PublisherEndpoint) else 0
        endpoints.append(
            EndpointView(
                role.value,
                name,
                type_name,
                topic.topic_id,
                topic.buffer_size,
                node.endpoints.is_attached(endpoint),
                endpoint.message_count,
                endpoint.dropped_count + lost,
                endpoint.misfit_count,
            )
        )
    if session is None:
        return BoardView(node.graph.node_name, "", False, False, None, tuple(endpoints))
    statistics = session.link.statistics
    return BoardView(
        node.graph.node_name,
        session.transport.peer,
        session.is_connected,
        session.link.is_settled,
        session.link.version,
        tuple(endpoints),
        statistics.bytes_received,
        session.outbox.sent_bytes,
        statistics.frames_received,
        sum(statistics.discarded.values()),
        statistics.discarded_bytes,
        statistics.resets,
        session.outbox.queued_bytes,
        statistics.damaged_frames,
        statistics.shortest_round_trip_s,
        session.baud,
        session.is_searching,
    )
