"""A cache for the names of the types in a registry."""

from __future__ import annotations

from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec


class TypeIndex:
    """The names of all types; each package is listed once."""

    def __init__(self, registry: Registry) -> None:
        self.registry = registry
        self._messages: dict[str, frozenset[str]] = {}
        self._services: dict[str, frozenset[str]] = {}

    def is_message(self, name: str) -> bool:
        """Return whether `package/Name` is a message, and not only the request or response of a service."""
        package = name.partition("/")[0]
        if package not in self._messages:
            self._messages[package] = frozenset(self.registry.messages(package))
        return name in self._messages[package]

    def is_service(self, name: str) -> bool:
        """Return whether `package/Name` is a service."""
        package = name.partition("/")[0]
        if package not in self._services:
            self._services[package] = frozenset(self.registry.services(package))
        return name in self._services[package]

    def header_of(self, message: str) -> str:
        """Return the type whose header contains a message: the message itself, or its service."""
        if not self.is_message(message):
            for suffix in ("Request", "Response"):
                service = message.removesuffix(suffix)
                if service != message and self.is_service(service):
                    return service
        return message

    def specs(self, name: str) -> list[MessageSpec]:
        """Return the message, or the service's request and response. Raises the errors of the registry."""
        if self.is_message(name):
            return [self.registry.message(name)]
        service = self.registry.service(name)
        return [service.request, service.response]
