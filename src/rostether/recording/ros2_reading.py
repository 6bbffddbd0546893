"""The common part of readers of ROS 2 recordings: topics as connections, and CDR as ROS 1 bytes."""

from __future__ import annotations

from collections.abc import Callable

from msgspec.structs import replace

from rostether.errors import DefinitionError, RostetherError, SerializationError, UnknownTypeError
from rostether.msgdef.full_text import SEPARATOR
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.spec import Ros2Message
from rostether.msgdef.ros2.to_ros1 import as_ros1_specs, ros1_name
from rostether.msgdef.spec import MessageSpec
from rostether.recording.recorded import Connection, Ros2Origin
from rostether.recording.ros2_qos import is_latching, profiles_text, read_profiles
from rostether.recording.ros2_types import RecordedDefinitions
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import MessageSupport, Ros2Types

CDR = "cdr"

_STAMPS = {"builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration"}


class RecordedTopics:
    """The topics of one ROS 2 recording.

    Their types have the form of ROS 1, or, with `is_native`, the fields of ROS 2, so that a conversion back
    to CDR loses nothing.
    """

    def __init__(self, *, is_native: bool) -> None:
        # Topics with messages that cannot be converted, and why.
        self.unreadable: dict[str, str] = {}
        self._is_native = is_native
        self._definitions = Ros2Definitions.from_environment()
        self._registry = Registry.from_environment()
        self._types: dict[tuple[str, str, str], MessageSupport] = {}
        self._convert: dict[Connection, Callable[[bytes], bytes]] = {}

    def connection(self, topic: str, origin: Ros2Origin, qos: object) -> Connection | None:
        """Return a topic as a connection, None if its type cannot be read: `unreadable` has the reason."""
        profiles = read_profiles(qos)
        key = (origin.type_name, origin.encoding, origin.definition)
        try:
            if key not in self._types:
                self._types[key] = self._find(origin)
        except RostetherError as error:
            self.unreadable[topic] = str(error)
            return None
        support = self._types[key]
        origin = replace(origin, qos=profiles_text(profiles))
        connection = Connection(topic, support.ros1_type, "", is_latching(profiles), origin)
        self._convert[connection] = support.converter.from_cdr
        return connection

    def convert(self, connection: Connection, cdr: bytes) -> bytes | None:
        """Return a message as ROS 1 bytes, None if it does not fit its type: `unreadable` has the reason."""
        try:
            return self._convert[connection](cdr)
        except SerializationError as error:
            self.unreadable.setdefault(connection.topic, f"a message does not fit its type: {error}")
            return None

    def _find(self, origin: Ros2Origin) -> MessageSupport:
        # Separate definitions: another topic of the recording may use the same name for another type.
        definitions = RecordedDefinitions(self._definitions)
        definitions.learn(origin)
        if self._is_native:
            return NativeTypes(NativeRegistry(definitions, self._registry)).by_name(origin.type_name)
        types = Ros2Types(self._registry, definitions)
        try:
            self._registry.message_type(ros1_name(origin.type_name))
        except DefinitionError:
            # Definitions of a workspace may be those of ROS 2, with bounds that ROS 1 cannot express.
            try:
                return types.message(_as_ros1_type(definitions.message(origin.type_name), definitions))
            except RostetherError:
                pass
        return types.by_name(origin.type_name)


def _as_ros1_type(message: Ros2Message, definitions: Ros2Definitions) -> MessageType:
    """Return a ROS 2 type as a ROS 1 type: stamps become `time`, and Header becomes that of ROS 1.

    Raises UnknownTypeError, and DefinitionError for a type that ROS 1 cannot express.
    """
    registry = Registry()
    own, *below = as_ros1_specs(message, definitions)
    parts = [
        f"{SEPARATOR}\nMSG: {each.full_name}\n{_text(each)}"
        for each in below
        if each.full_name not in _STAMPS and not _is_known(registry, each.full_name)
    ]
    registry.add_full_text(own.full_name, "\n".join([_text(own), *parts]))
    return registry.message_type(own.full_name)


def _text(spec: MessageSpec) -> str:
    lines = [f"{each.type} {each.name}={each.text}" for each in spec.constants]
    for field in spec.fields:
        kind = replace(field.type, base=_STAMPS.get(field.type.base, field.type.base))
        lines.append(f"{kind} {field.name}")
    return "\n".join(lines)


def _is_known(registry: Registry, name: str) -> bool:
    try:
        registry.message(name)
    except UnknownTypeError:
        return False
    return True
