"""The topics of a ROS 1 graph as its master lists them."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct

from rostether.cli.access.ros1_access import master_client
from rostether.errors import UnknownNameError
from rostether.graph.joint_marks import is_mark
from rostether.msgdef.interface import ANY_TYPE
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient

UNKNOWN_TYPE = "unknown type"


class TopicView(Struct, frozen=True):
    """One topic; `type` is "unknown type" until a publisher or subscriber has registered one."""

    name: str
    type: str
    publishers: list[str]
    subscribers: list[str]

    @property
    def known_type(self) -> str | None:
        """The type, None while it is unknown."""
        return None if self.type in (UNKNOWN_TYPE, ANY_TYPE) else self.type


async def fetch_topics(environment: RosEnvironment) -> list[TopicView]:
    """Return all topics that can carry messages, sorted by name. Raises MasterUnreachableError."""
    async with master_client(environment) as client:
        publishers, subscribers, _ = await client.system_state()
        types = await client.topic_types()
    return [
        TopicView(name, types.get(name, UNKNOWN_TYPE), publishers.get(name, []), subscribers.get(name, []))
        for name in sorted(publishers.keys() | subscribers.keys())
        if not is_mark(name)
    ]


async def node_uris(client: MasterClient, nodes: Iterable[str]) -> dict[str, str | None]:
    """Return each node's URI, None for a node that has just left."""
    uris: dict[str, str | None] = {}
    for node in nodes:
        try:
            uris[node] = await client.lookup_node(node)
        except UnknownNameError:
            uris[node] = None
    return uris
