"""The ROS 2 definitions of ROS 1 types, found or derived, and ROS 1 definitions of ROS 2 types."""

from __future__ import annotations

from msgspec.structs import replace

from rostether.errors import UnknownTypeError
from rostether.msgdef.full_text import message_full_text
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.md5sum import digest, message_md5_text
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definition_text import message_text
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.from_ros1 import derive
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service
from rostether.msgdef.ros2.to_ros1 import MessageSource, as_ros1_specs
from rostether.msgdef.spec import MessageSpec
from rostether.serde.cdr.converter import CdrConverter, compile_message
from rostether.serde.cdr.renamed_types import ros1_message_name, ros2_message_name, ros2_service_name
from rostether.serde.type_tree import TypeTrees


class PairedDefinitions:
    """The ROS 2 definitions on this machine; missing ones are derived from a registry."""

    def __init__(self, registry: Registry, definitions: Ros2Definitions) -> None:
        self._registry = registry
        self._definitions = definitions
        self._derived: dict[str, Ros2Message] = {}

    @property
    def distro(self) -> str:
        """The ROS 2 distribution of the definitions."""
        return self._definitions.distro

    def message(self, name: str) -> Ros2Message:
        """Return a message by `package/msg/Name`. Raises UnknownTypeError, DefinitionError."""
        if self._definitions.has(name):
            return self._definitions.message(name)
        derived = self._derived.get(name)
        if derived is None:
            derived = derive(self._registry.message(ros1_message_name(name)), self._registry)
            self._derived[name] = derived
        return derived

    def text(self, name: str) -> str:
        """Return a message's text by `package/msg/Name`. Raises the same errors as `message`."""
        return (
            self._definitions.text(name) if self._definitions.has(name) else message_text(self.message(name))
        )

    def counterpart(self, ros1_name: str) -> Ros2Message:
        """Return the ROS 2 form of a ROS 1 message `package/Name`. Raises the same errors as `message`."""
        name = ros2_message_name(ros1_name)
        if self._definitions.has(name):
            return self._definitions.message(name)
        return derive(self._registry.message(ros1_name), self._registry)

    def service_counterpart(self, service_type: ServiceType) -> Ros2Service:
        """Return the ROS 2 form of a ROS 1 service. Raises the same errors as `message`."""
        name = ros2_service_name(service_type.name)
        if self._definitions.has(name):
            return self._definitions.service(name)
        package, _, short_name = name.partition("/srv/")
        request, response = (
            replace(
                derive(self._registry.message(message.name), self._registry),
                kind="srv",
                name=f"{short_name}_{suffix}",
            )
            for message, suffix in ((service_type.request, "Request"), (service_type.response, "Response"))
        )
        return Ros2Service(package, short_name, request, response)

    def converter(self, ros1_name: str, ros2: Ros2Message) -> CdrConverter:
        """Return the converter of a pair. Raises TypeMismatchError, and the errors of `message`."""
        return compile_message(TypeTrees(self._registry).struct(ros1_name), ros2, self.message)


class NativeView:
    """The fields of a ROS 2 message in ROS 1's form; no field is dropped or added."""

    def __init__(self, ros2: Ros2Message, definitions: MessageSource) -> None:
        specs = as_ros1_specs(ros2, definitions)
        self._specs = {spec.full_name: spec for spec in specs}
        spec = specs[0]
        self.md5_text = message_md5_text(spec, self.message)
        self.message_type = MessageType(
            spec.full_name, digest(self.md5_text), message_full_text(spec, self.message)
        )
        tree = TypeTrees(self).struct(spec.full_name)
        self.converter = compile_message(tree, ros2, definitions.message)

    def message(self, name: str) -> MessageSpec:
        """Return the ROS 1 definition of a part by `package/Name`. Raises UnknownTypeError."""
        if name not in self._specs:
            raise UnknownTypeError(f"{name} is not part of {next(iter(self._specs))}")
        return self._specs[name]
