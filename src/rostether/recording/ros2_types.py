"""The types and topics of ROS 2 recordings: definitions in the files, and CDR as ROS 1 bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from msgspec.structs import replace

from rostether.errors import DefinitionError, RostetherError, SerializationError, UnknownTypeError
from rostether.msgdef.full_text import SEPARATOR, split_full_text
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.action_parts import ActionParts
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.parse import parse_message
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service
from rostether.msgdef.ros2.to_ros1 import as_ros1_specs, ros1_name
from rostether.msgdef.spec import MessageSpec
from rostether.recording.recorded import Connection, Ros2Origin
from rostether.recording.ros2_qos import is_latching, profiles_text, read_profiles
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import MessageSupport, Ros2Types

CDR = "cdr"
ROS2MSG = "ros2msg"

_STAMPS = {"builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration"}


class RecordedDefinitions(Ros2Definitions):
    """The definitions of a recording; missing ones are those of `others`, by default of the environment.

    The first definition of a name is used.
    """

    def __init__(self, others: Ros2Definitions | None = None) -> None:
        self._others = others or Ros2Definitions.from_environment()
        super().__init__(bundled=False, distro=self._others.distro)
        self._texts: dict[str, str] = {}

    def learn(self, origin: Ros2Origin) -> None:
        """Add the definition texts of a topic. Raises DefinitionError."""
        if origin.encoding != ROS2MSG or not origin.definition:
            return
        for name, text in split_full_text(origin.type_name, origin.definition).items():
            package, _, rest = name.partition("/")
            self._texts.setdefault(f"{package}/msg/{rest.removeprefix('msg/')}", text)

    def add(self, messages: Iterable[Ros2Message]) -> None:
        """Add other definitions; known ones are not replaced."""
        self._others.add(messages)

    @property
    def searched_folders(self) -> str:
        """The searched folders, as text for errors."""
        return self._others.searched_folders

    def message(self, name: str) -> Ros2Message:
        """Return a message by `package/msg/Name`. Raises UnknownTypeError, DefinitionError."""
        text = self._texts.get(name)
        if text is None:
            return self._others.message(name)
        found = self._messages.get(name)
        if found is None:
            package, _, short_name = name.partition("/msg/")
            found = self._messages[name] = parse_message(text, package=package, name=short_name)
        return found

    def text(self, name: str) -> str:
        """Return a message's own text. Raises the same errors as `message`."""
        return self._texts.get(name) or self._others.text(name)

    def service(self, name: str) -> Ros2Service:
        """Return a service by `package/srv/Name`. Raises UnknownTypeError, DefinitionError."""
        return self._others.service(name)

    def action(self, name: str) -> ActionParts:
        """Return an action by `package/action/Name`. Raises UnknownTypeError, DefinitionError."""
        return self._others.action(name)

    def has(self, name: str) -> bool:
        """Return whether a message or service is known."""
        return name in self._texts or self._others.has(name)


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
