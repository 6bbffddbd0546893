"""The support of a type on a ROS 2 graph: its name, hash, ROS 1 form, and converter."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from msgspec import Struct

from rostether.errors import DefinitionError, TypeMismatchError
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.md5sum import digest
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definition_text import full_text
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Service
from rostether.msgdef.search_waiting import definitions_searched
from rostether.ros2.types.paired_definitions import NativeView, PairedDefinitions
from rostether.ros2.types.type_hash import message_hash, service_hash
from rostether.serde.cdr.converter import CdrConverter
from rostether.serde.cdr.renamed_types import ros1_message_name, ros1_service_name

# The hash that matches every definition of a type.
ANY_HASH = ""

# Messages without fields may have an empty definition.
_MD5SUM_OF_NOTHING = digest("")


class MessageSupport(Struct, frozen=True):
    """One message type: `name` as `sensor_msgs/msg/Imu`, its RIHS01 hash, its ROS 1 type, and a converter."""

    name: str
    type_hash: str
    ros1_type: MessageType
    converter: CdrConverter


class ServiceSupport(Struct, frozen=True):
    """One service type: `name` as `std_srvs/srv/SetBool`, its RIHS01 hash, its converters and ROS 1 type."""

    name: str
    type_hash: str
    request: CdrConverter
    response: CdrConverter
    ros1_type: ServiceType


def native_message(ros2: Ros2Message, definitions: Ros2Definitions | PairedDefinitions) -> MessageSupport:
    """Return the support of a message with its native fields in ROS 1's form.

    Raises UnknownTypeError, DefinitionError for nested types.
    """
    view = NativeView(ros2, definitions)
    return MessageSupport(ros2.full_name, message_hash(ros2, definitions), view.message_type, view.converter)


def native_service(ros2: Ros2Service, definitions: Ros2Definitions | PairedDefinitions) -> ServiceSupport:
    """Return the support of a service. Raises the same errors as `native_message`."""
    request, response = NativeView(ros2.request, definitions), NativeView(ros2.response, definitions)
    md5sum = digest(request.md5_text + response.md5_text)
    return ServiceSupport(
        ros2.full_name,
        service_hash(ros2, definitions),
        request.converter,
        response.converter,
        ServiceType(f"{ros2.package}/{ros2.name}", md5sum, request.message_type, response.message_type),
    )


SupportT = TypeVar("SupportT", MessageSupport, ServiceSupport)


class Ros2Types:
    """Types by their ROS 1 definition or ROS 2 name, each compiled on first use.

    A type without a ROS 2 definition gets one derived from its ROS 1 definition. With `asks_nodes`, graphs
    ask the nodes of publishers for definitions that are not known here.
    """

    asks_nodes = True

    def __init__(self, registry: Registry, definitions: Ros2Definitions) -> None:
        self.registry = registry
        self.definitions = definitions
        self._messages: dict[tuple[str, str], MessageSupport] = {}
        self._services: dict[tuple[str, str], ServiceSupport] = {}
        self._by_name: dict[str, MessageSupport] = {}
        self._services_by_name: dict[str, ServiceSupport] = {}
        self._native_services: dict[str, ServiceSupport] = {}

    async def searched(self) -> None:
        """Wait until all folders of ROS 1 and ROS 2 definitions have been searched, in threads."""
        await definitions_searched(self.registry)
        if not self.definitions.is_searched:
            await asyncio.to_thread(self.definitions.search)

    def message(self, message_type: MessageType) -> MessageSupport:
        """Return the support of a ROS 1 message type, using the type's own definition.

        Raises UnknownTypeError, DefinitionError, TypeMismatchError.
        """
        key = (message_type.name, message_type.md5sum)
        support = self._messages.get(key)
        if support is None:
            source = PairedDefinitions(self._source(message_type), self.definitions)
            ros2 = source.counterpart(message_type.name)
            support = self._messages[key] = MessageSupport(
                ros2.full_name,
                message_hash(ros2, source),
                message_type,
                source.converter(message_type.name, ros2),
            )
        return support

    def service(self, service_type: ServiceType) -> ServiceSupport:
        """Return the support of a ROS 1 service type. Raises the same errors as `message`."""
        key = (service_type.name, service_type.md5sum)
        support = self._services.get(key)
        if support is None:
            source = PairedDefinitions(self._service_source(service_type), self.definitions)
            ros2 = source.service_counterpart(service_type)
            support = self._services[key] = ServiceSupport(
                ros2.full_name,
                service_hash(ros2, source),
                source.converter(service_type.request.name, ros2.request),
                source.converter(service_type.response.name, ros2.response),
                service_type,
            )
        return support

    def by_name(self, name: str) -> MessageSupport:
        """Return a ROS 2 message: in the form of the ROS 1 message with its name if that fits, else natively.

        Raises UnknownTypeError, DefinitionError.
        """
        support = self._by_name.get(name)
        if support is None:
            support = _named(
                name, lambda: self.message(self.registry.message_type(ros1_message_name(name)))
            ) or native_message(self.definitions.message(name), self.definitions)
            self._by_name[name] = support
        return support

    def received(self, name: str, type_hash: str) -> MessageSupport:
        """Return the type of received messages by its name and its publisher's hash (or `ANY_HASH`).

        This class uses only the name. Raises the same errors as `by_name`.
        """
        return self.by_name(name)

    def service_by_name(self, name: str) -> ServiceSupport:
        """Return a ROS 2 service like `by_name`. Raises the same errors."""
        support = self._services_by_name.get(name)
        if support is None:
            support = _named(
                name, lambda: self.service(self.registry.service_type(ros1_service_name(name)))
            ) or self._native_service(name)
            self._services_by_name[name] = support
        return support

    def native_service(self, name: str) -> ServiceType:
        """Return a ROS 2 service with its native fields in ROS 1's form.

        Raises UnknownTypeError, DefinitionError.
        """
        return self._native_service(name).ros1_type

    def full_text(self, message_type: MessageType) -> str:
        """Return the ROS 2 definition text of a message type and of its nested types, as in ROS 2 bags.

        Raises the same errors as `message`.
        """
        source = self._definitions_of(message_type)
        return full_text(source.message(self.message(message_type).name), source)

    def _definitions_of(self, message_type: MessageType) -> PairedDefinitions:
        return PairedDefinitions(self._source(message_type), self.definitions)

    def _native_service(self, name: str) -> ServiceSupport:
        support = self._native_services.get(name)
        if support is None:
            support = native_service(self.definitions.service(name), self.definitions)
            self._native_services[name] = support
        return support

    def _source(self, message_type: MessageType) -> Registry:
        """Return a registry with the type's own definition: `registry`, or one with the text of the type."""
        try:
            if self.registry.message_type(message_type.name).md5sum == message_type.md5sum:
                return self.registry
        except DefinitionError:
            pass
        if not message_type.definition and message_type.md5sum != _MD5SUM_OF_NOTHING:
            return self.registry
        return Registry.of_full_text(message_type.name, message_type.definition)

    def _service_source(self, service_type: ServiceType) -> Registry:
        request, response = service_type.request, service_type.response
        sources = self._source(request), self._source(response)
        if sources == (self.registry, self.registry):
            return self.registry
        learned = Registry(bundled=False)
        for message in (request, response):
            learned.add_full_text(message.name, message.definition)
        return learned


def _named(name: str, find: Callable[[], SupportT]) -> SupportT | None:
    """Return the support of a ROS 1 type, if its counterpart in ROS 2 has this name."""
    try:
        support = find()
    except (DefinitionError, TypeMismatchError):
        return None
    return support if support.name == name else None
