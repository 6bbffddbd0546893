"""A world for tests of endpoints: types, a graph in memory, a reporter."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Sequence

from rostether.bridge.reporter import Notices
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.msgdef.registry import Registry
from rostether.rosserial.events import ServiceAnnounced, ServiceRole, TopicAnnounced, TopicRole
from rostether.rosserial.packets import TopicInfo
from rostether.serde.store import TypeStore
from unit.bridge.doubles import RecordingReporter

STORE = TypeStore(Registry())


def text(value: str) -> bytes:
    """Return a serialized std_msgs/String."""
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def topic_info(
    topic: str = "chatter",
    type_name: str = "std_msgs/String",
    *,
    topic_id: int = 125,
    buffer_size: int = 280,
    md5sum: str | None = None,
) -> TopicInfo:
    """Return a board's announcement of a topic."""
    if md5sum is None:
        md5sum = STORE.registry.message_type(type_name).md5sum
    return TopicInfo(topic_id, topic, type_name, md5sum, buffer_size)


def publisher(
    topic: str = "chatter", type_name: str = "std_msgs/String", *, topic_id: int = 125
) -> TopicAnnounced:
    return TopicAnnounced(TopicRole.PUBLISHER, topic_info(topic, type_name, topic_id=topic_id))


def subscriber(
    topic: str = "chatter", type_name: str = "std_msgs/String", *, topic_id: int = 100, buffer_size: int = 280
) -> TopicAnnounced:
    info = topic_info(topic, type_name, topic_id=topic_id, buffer_size=buffer_size)
    return TopicAnnounced(TopicRole.SUBSCRIBER, info)


def service(
    role: ServiceRole, name: str = "switch", type_name: str = "std_srvs/SetBool", *, first_id: int = 110
) -> ServiceAnnounced:
    """Return a board's announcement of a service; requests have `first_id`, responses the next id."""
    types = STORE.registry.service_type(type_name)
    return ServiceAnnounced(
        role,
        name,
        type_name,
        TopicInfo(first_id, name, type_name, types.request.md5sum, 280),
        TopicInfo(first_id + 1, name, type_name, types.response.md5sum, 280),
    )


class World:
    """A network with the board's node and another node that subscribes and publishes."""

    def __init__(self) -> None:
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.board: MemoryGraph
        self.peer: MemoryGraph
        self.notices = Notices(self.reporter, "/board", asyncio.get_running_loop().time)

    async def open(self) -> World:
        self.board = await self.network.join("/board")
        self.peer = await self.network.join("/peer")
        return self

    async def listen(self, topic: str, type_name: str = "std_msgs/String") -> list[bytes]:
        """Subscribe with the other node; return the list of the received messages."""
        received: list[bytes] = []

        def take(payloads: Sequence[bytes]) -> None:
            received.extend(payloads)

        await self.peer.subscribe(topic, STORE.registry.message_type(type_name), take)
        return received
