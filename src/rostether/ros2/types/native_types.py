"""Types for programs and tools on a ROS 2 graph: the fields of ROS 2 in ROS 1 serialization."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.paired_definitions import PairedDefinitions
from rostether.ros2.types.type_support import (
    MessageSupport,
    Ros2Types,
    ServiceSupport,
    SupportT,
    native_message,
    native_service,
)
from rostether.serde.type_tree import Array, Node, Struct
from rostether.serde.values import Message, MessageClasses


class NativeTypes(Ros2Types):
    """A graph's types from a `NativeRegistry`; unknown types are handled as in `Ros2Types`."""

    registry: NativeRegistry

    def __init__(self, registry: NativeRegistry) -> None:
        super().__init__(registry, registry.definitions)
        self._native_supports: dict[str, MessageSupport] = {}
        self._native_service_supports: dict[str, ServiceSupport] = {}

    def message(self, message_type: MessageType) -> MessageSupport:
        """Return a message type's support in ROS 2. Raises the same errors as `Ros2Types.message`."""
        support = self._find(message_type, self._native_supports, self.registry.message_type, self._describe)
        return super().message(message_type) if support is None else support

    def service(self, service_type: ServiceType) -> ServiceSupport:
        """Return a service type's support in ROS 2. Raises the same errors as `Ros2Types.service`."""
        support = self._find(
            service_type, self._native_service_supports, self.registry.service_type, self._describe_service
        )
        return super().service(service_type) if support is None else support

    def _find(
        self,
        wanted: MessageType | ServiceType,
        supports: dict[str, SupportT],
        native_type: Callable[[str], MessageType | ServiceType],
        describe: Callable[[str], SupportT],
    ) -> SupportT | None:
        """Return the support of a native type; None for a peer's own definition."""
        support = supports.get(wanted.name)
        try:
            if support is None and native_type(wanted.name).md5sum == wanted.md5sum:
                support = supports[wanted.name] = describe(wanted.name)
        except UnknownTypeError:
            return None
        return support if support is not None and support.ros1_type.md5sum == wanted.md5sum else None

    def _definitions_of(self, message_type: MessageType) -> PairedDefinitions:
        self.message(message_type)
        support = self._native_supports.get(message_type.name)
        if support is not None and support.ros1_type.md5sum == message_type.md5sum:
            return self.registry.source
        return super()._definitions_of(message_type)

    def _describe(self, name: str) -> MessageSupport:
        return native_message(self.registry.ros2_message(name), self.registry.source)

    def _describe_service(self, name: str) -> ServiceSupport:
        return native_service(self.registry.ros2_service(name), self.registry.source)


class NativeClasses(MessageClasses):
    """Message classes with the default values of ROS 2 definitions: as in rclpy, a Quaternion's w is 1."""

    are_shared = False

    def __init__(self, registry: NativeRegistry) -> None:
        super().__init__()
        self._registry = registry

    def _make(self, tree: Struct) -> type[Message]:
        message_class = super()._make(tree)
        defaults = self._defaults(tree)
        if defaults:
            message_class._zeros = tuple(
                (member.name, _maker(member.node, defaults[member.name]) if member.name in defaults else zero)
                for member, (_, zero) in zip(tree.members, message_class._zeros, strict=True)
            )
        return message_class

    def _defaults(self, tree: Struct) -> dict[str, Any]:
        try:
            definition = self._registry.ros2_message(tree.name)
        except DefinitionError:
            # A peer's own definition in ROS 1's form has no defaults.
            return {}
        return {field.name: field.default for field in definition.fields if field.default is not None}


def _maker(node: Node, default: Any) -> Any:
    """Return an immutable default value, or a function that creates a mutable one."""
    if not isinstance(node, Array):
        return default
    values = tuple(default)
    return bytes(values) if node.is_bytes else lambda: list(values)


def types_of(registry: Registry) -> Ros2Types:
    """Return the types of a registry: those of ROS 2 from a `NativeRegistry`, else derived from ROS 1."""
    if isinstance(registry, NativeRegistry):
        return NativeTypes(registry)
    return Ros2Types(registry, Ros2Definitions.from_environment())
