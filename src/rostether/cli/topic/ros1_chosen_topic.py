"""The topics of a ROS 1 graph as its master lists them, and the topic and field that a user typed.

`/scan/ranges[3]` is a topic, or an element of `/scan`.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.cli.access.ros1_access import master_client, resolve
from rostether.cli.shell.output import warn
from rostether.errors import ConfigError, DefinitionError, GraphError, UnknownNameError
from rostether.graph.joint_marks import is_mark
from rostether.graph.ports import TopicEntry
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.text import unpublished_warning
from rostether.msgdef.interface import ANY_TYPE
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.graph_view import take_snapshot
from rostether.ros1.node.master_client import MasterClient
from rostether.serde.field_path import FieldPath

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.serde.store import TypeStore

# The interval at which the master is asked for a topic that does not exist yet, as in rostopic.
POLL_S = 0.1


def known_type(topic: TopicEntry) -> str | None:
    """Return a topic's type, None until a publisher or subscriber has registered one."""
    return None if topic.type == ANY_TYPE else topic.type


async def fetch_topics(environment: RosEnvironment) -> list[TopicEntry]:
    """Return all topics that can carry messages, sorted by name. Raises MasterUnreachableError."""
    async with master_client(environment) as client:
        snapshot = await take_snapshot(client)
    return [topic for name, topic in snapshot.topics.items() if not is_mark(name)]


async def node_uris(client: MasterClient, nodes: Iterable[str]) -> dict[str, str | None]:
    """Return each node's URI, None for a node that has just left."""
    uris: dict[str, str | None] = {}
    for node in nodes:
        try:
            uris[node] = await client.lookup_node(node)
        except UnknownNameError:
            uris[node] = None
    return uris


class ChosenTopic(Struct, frozen=True):
    """A topic that exists, its type, and the path to a field in it, empty for the whole message."""

    topic: str
    type: str
    field: str


def resolve_with_field(text: str, environment: RosEnvironment) -> str:
    """Return the full form of a topic followed by a field. Raises InvalidNameError."""
    name, bracket, indices = text.partition("[")
    return resolve(name, environment) + bracket + indices


def choose_topic(name: str, topics: Sequence[TopicEntry], store: TypeStore) -> ChosenTopic | None:
    """Return the topic of a full name, else the longest topic that has the rest of the name as a field.

    None if there is no such topic, or if its type is not known yet.
    """
    known = {topic.name: topic.type for topic in topics if known_type(topic) is not None}
    name = name.rstrip("/") or "/"
    if name in known:
        return ChosenTopic(name, known[name], "")
    prefixes = [topic for topic in known if name.startswith(f"{topic}/")]
    for topic in sorted(prefixes, key=len, reverse=True):
        field = name[len(topic) + 1 :]
        try:
            FieldPath(store.codec(known[topic]), field)
        except ConfigError:
            continue
        except DefinitionError:
            # A type that is not installed may have the field: its publisher sends the definition.
            pass
        return ChosenTopic(topic, known[topic], field)
    return None


async def wait_for_topic(name: str, graph: TypedGraph, environment: RosEnvironment) -> ChosenTopic:
    """Return the topic of a full name, or of a topic and a field, as soon as its type is known.

    Raises ConfigError for a field that a topic's type does not have, GraphError if the node is shut down
    before that.
    """
    is_reported = False
    async with task_beside(graph.raw.wait_closed()) as leaving:
        while not leaving.done():
            topics = await fetch_topics(environment)
            chosen = choose_topic(name, topics, graph.store)
            if chosen is not None:
                return chosen
            if not is_reported:
                is_reported = True
                _refuse_wrong_field(name, topics, graph.store)
                names = [topic.name for topic in topics if known_type(topic) is not None]
                warn(unpublished_warning(name, names))
            await asyncio.wait({leaving}, timeout=POLL_S)
    raise GraphError(f"the node was shut down before topic {name} was published")


def _refuse_wrong_field(name: str, topics: Sequence[TopicEntry], store: TypeStore) -> None:
    """Raise ConfigError for a field that the messages of a topic do not have."""
    for topic in topics:
        if known_type(topic) is None or not name.startswith(f"{topic.name}/"):
            continue
        if any(each.name.startswith(f"{topic.name}/") for each in topics):
            # The typed name may be that of a topic below this one that does not exist yet.
            continue
        try:
            FieldPath(store.codec(topic.type), name[len(topic.name) + 1 :])
        except ConfigError as error:
            raise ConfigError(f"in {topic.name}, {error}") from None
        except DefinitionError:
            continue
