"""Caches the names of the types in a registry."""

from __future__ import annotations

from functools import cache

from rostether.msgdef.parse_srv import service_of
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec


class TypeIndex:
    """The names of all types; each package is listed once."""

    def __init__(self, registry: Registry) -> None:
        self.registry = registry
        self._messages = cache(lambda package: frozenset(registry.messages(package)))
        self._services = cache(lambda package: frozenset(registry.services(package)))

    def is_message(self, name: str) -> bool:
        """Return whether `package/Name` is a message, and not only the request or response of a service."""
        return name in self._messages(name.partition("/")[0])

    def is_service(self, name: str) -> bool:
        """Return whether `package/Name` is a service."""
        return name in self._services(name.partition("/")[0])

    def header_of(self, message: str) -> str:
        """Return the type whose header contains a message: the message itself, or its service."""
        service = service_of(message)
        return service if self.is_service(service) and not self.is_message(message) else message

    def specs(self, name: str) -> list[MessageSpec]:
        """Return the message, or the service's request and response. Raises the errors of the registry."""
        if self.is_message(name):
            return [self.registry.message(name)]
        service = self.registry.service(name)
        return [service.request, service.response]
