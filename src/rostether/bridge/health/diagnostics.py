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
                role=role.value,
                name=name,
                type=type_name,
                topic_id=topic.topic_id,
                buffer_bytes=topic.buffer_size,
                is_attached=node.endpoints.is_attached(endpoint),
                message_count=endpoint.message_count,
                dropped_count=endpoint.dropped_count + lost,
                misfit_count=endpoint.misfit_count,
            )
        )
    if session is None:
        return BoardView(node.graph.node_name, "", False, False, None, tuple(endpoints))
    statistics = session.link.statistics
    return BoardView(
        node=node.graph.node_name,
        peer=session.transport.peer,
        is_connected=session.is_connected,
        is_settled=session.link.is_settled,
        protocol_version=session.link.version,
        endpoints=tuple(endpoints),
        received_bytes=statistics.bytes_received,
        sent_bytes=session.outbox.sent_bytes,
        received_frames=statistics.frames_received,
        discarded_frames=sum(statistics.discarded.values()),
        discarded_bytes=statistics.discarded_bytes,
        reset_count=statistics.resets,
        queued_bytes=session.outbox.queued_bytes,
        damaged_frames=statistics.damaged_frames,
        round_trip_s=statistics.shortest_round_trip_s,
        baud=session.baud,
        is_searching=session.is_searching,
    )
