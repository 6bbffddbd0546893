"""Types for tools on a ROS 2 graph: the fields of ROS 2 in ROS 1 serialization."""

from __future__ import annotations

from rostether.errors import UnknownTypeError
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.paired_definitions import NativeView, PairedDefinitions, native_service_type
from rostether.ros2.types.type_hash import message_hash, service_hash
from rostether.ros2.types.type_support import MessageSupport, Ros2Types, ServiceSupport


class NativeTypes(Ros2Types):
    """A graph's types from a `NativeRegistry`; unknown types are handled like in `Ros2Types`."""

    def __init__(self, registry: NativeRegistry) -> None:
        super().__init__(registry, registry.definitions)
        self._native = registry
        self._native_supports: dict[str, MessageSupport] = {}
        self._native_service_supports: dict[str, ServiceSupport] = {}

    def message(self, message_type: MessageType) -> MessageSupport:
        """Return a message type's support in ROS 2. Raises as `Ros2Types.message`."""
        name = message_type.name
        support = self._native_supports.get(name)
        try:
            if support is None and self._native.message_type(name).md5sum == message_type.md5sum:
                support = self._native_supports[name] = self._describe(name)
        except UnknownTypeError:
            pass  # A peer's own definition.
        if support is not None and support.ros1_type.md5sum == message_type.md5sum:
            return support
        return super().message(message_type)

    def service(self, service_type: ServiceType) -> ServiceSupport:
        """Return a service type's support in ROS 2. Raises as `Ros2Types.service`."""
        name = service_type.name
        support = self._native_service_supports.get(name)
        try:
            if support is None and self._native.service_type(name).md5sum == service_type.md5sum:
                support = self._native_service_supports[name] = self._describe_service(name)
        except UnknownTypeError:
            pass  # A peer's own definition.
        if support is not None and support.ros1_type.md5sum == service_type.md5sum:
            return support
        return super().service(service_type)

    def _texts(self, message_type: MessageType) -> PairedDefinitions:
        self.message(message_type)
        support = self._native_supports.get(message_type.name)
        if support is not None and support.ros1_type.md5sum == message_type.md5sum:
            return self._native.source
        return super()._texts(message_type)

    def _describe(self, name: str) -> MessageSupport:
        source = self._native.source
        ros2 = self._native.ros2_message(name)
        view = NativeView(ros2, source)
        return MessageSupport(ros2.full_name, message_hash(ros2, source), view.message_type, view.converter)

    def _describe_service(self, name: str) -> ServiceSupport:
        source = self._native.source
        ros2 = self._native.ros2_service(name)
        request, response = NativeView(ros2.request, source), NativeView(ros2.response, source)
        return ServiceSupport(
            ros2.full_name,
            service_hash(ros2, source),
            request.converter,
            response.converter,
            native_service_type(ros2, request, response),
        )
