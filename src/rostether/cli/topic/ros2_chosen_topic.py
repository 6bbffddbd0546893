"""Finds the topic of a ROS 2 graph that a user typed, its type, and the field in it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.cli.shell.output import warn
from rostether.errors import ConfigError, DefinitionError, TypeMismatchError
from rostether.mechanisms.text import unpublished_warning
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Type
from rostether.ros2.endpoint_info import EndpointKind
from rostether.ros2.graph_view import GraphView
from rostether.ros2.naming import validate_topic_name
from rostether.ros2.types.native_registry import short_name

if TYPE_CHECKING:
    from rostether.cli.access.ros2_tool_node import ToolNode
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.serde.field_path import FieldPath

# The interval at which the graph is searched for a topic that does not exist yet, as on ROS 1.
POLL_S = 0.1


class ChosenRos2Topic(Struct, frozen=True):
    """A topic, the short name of its type, and the chosen field with its type, None for the whole message."""

    topic: str
    type: str
    path: FieldPath | None = None
    field_type: Ros2Type | None = None


async def choose_ros2_topic(
    tool: ToolNode, text: str, type_name: str | None = None, field: str = "", *, needs_definition: bool = True
) -> ChosenRos2Topic:
    """Return the typed topic; wait for its first publisher, unless its type was typed too.

    `/imu/angular_velocity` is a field if there is no topic with this name. Raises UnknownTypeError,
    ConfigError for a field that the type lacks, TypeMismatchError for a topic with several types,
    InvalidNameError.
    """
    name, bracket, indices = text.partition("[")
    name = tool.graph.resolve(name.rstrip("/") or "/")
    if type_name is not None:
        return _with_field(tool, name, short_name(type_name), field)
    wanted = name + bracket + indices
    view = await tool.snapshot_when(lambda seen: _published(seen, wanted) is not None)
    found = _published(view, wanted)
    if found is None:
        # No node of ROS 2 can publish a name such as /sensors/1.
        validate_topic_name(name)
        warn(unpublished_warning(wanted, view.names([EndpointKind.PUBLISHER])))
    while found is None:
        await asyncio.sleep(POLL_S)
        view = await tool.snapshot()
        found = _published(view, wanted)
    types = view.types([EndpointKind.PUBLISHER], found)
    if len(types) > 1:
        raise TypeMismatchError(
            f"topic {found} has more than one type ({', '.join(types)}); give the type after the topic"
        )
    if not needs_definition and found == wanted:
        return ChosenRos2Topic(found, short_name(types[0]))
    await tool.learn_type(view, found)
    return _with_field(tool, found, short_name(types[0]), field or wanted[len(found) + 1 :])


def _published(view: GraphView, name: str) -> str | None:
    """Return the topic with this name, else the longest topic of which the name may be a field."""
    topics = view.names([EndpointKind.PUBLISHER], with_hidden=True)
    if name in topics:
        return name
    return max((topic for topic in topics if name.startswith(f"{topic}/")), key=len, default=None)


def _with_field(tool: ToolNode, topic: str, type_name: str, field: str) -> ChosenRos2Topic:
    from rostether.serde.field_path import FieldPath

    codec = tool.graph.store.codec(type_name)
    if not field:
        return ChosenRos2Topic(topic, type_name)
    path = FieldPath(codec, field.replace(".", "/"))
    return ChosenRos2Topic(topic, type_name, path, field_type(tool.registry, type_name, path.text))


def field_type(registry: NativeRegistry, type_name: str, path: str) -> Ros2Type:
    """Return the ROS 2 type of the field at a path, or of one of its elements for `[0]`.

    Raises ConfigError for a field that the type lacks.
    """
    definition: Ros2Message | None = registry.ros2_message(type_name)
    found: Ros2Type | None = None
    for part in path.split("/"):
        name, bracket, _ = part.partition("[")
        fields = {field.name: field.type for field in definition.fields} if definition is not None else {}
        if name not in fields:
            parent = found.base if found is not None else "it"
            known = ", ".join(fields) or "no fields"
            raise ConfigError(f"{type_name} has no field {path!r}; {parent} has {known}")
        found = fields[name]
        if bracket and ":" not in part:
            found = Ros2Type(found.base)
        try:
            definition = None if found.base in PRIMITIVE_TYPES else registry.ros2_message(found.base)
        except DefinitionError:
            definition = None
    assert found is not None
    return found
