"""Settings of a gateway for Foxglove: its address, its clients, and how much of the graph it serves."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rostether.errors import ConfigError
from rostether.gateways.foxglove.limits import FoxgloveLimits

DEFAULT_HOST = "localhost"
DEFAULT_PORT = 8765
"""The default port of Foxglove."""

CAPABILITIES = (
    "clientPublish",
    "parameters",
    "parametersSubscribe",
    "services",
    "connectionGraph",
    "assets",
)
"""What clients may do besides reading topics; the time is also sent if it is simulated."""


@dataclass(frozen=True, slots=True)
class NameFilter:
    """Names that are offered: those that any of the patterns matches as a whole; None is every name."""

    patterns: tuple[re.Pattern[str], ...] | None = None

    @classmethod
    def of(cls, expressions: Iterable[str], source: str) -> NameFilter:
        """Compile regular expressions; `source` is who gave them. Raises ConfigError."""
        try:
            return cls(tuple(re.compile(each) for each in expressions))
        except re.error as error:
            raise ConfigError(f"{source}: {error.pattern!r} is no regular expression: {error}") from None

    def includes(self, name: str) -> bool:
        """Tell whether a name is offered."""
        return self.patterns is None or any(pattern.fullmatch(name) for pattern in self.patterns)


@dataclass(frozen=True, slots=True)
class FoxgloveSettings:
    """How a gateway serves.

    `host` is one name or address of ours, `localhost` both loopback addresses. Clients must give `token`
    where it is not empty; `origins` are more web pages that may connect (`*`: all), `allow` networks.
    With a certificate and its key, files, connections are encrypted (wss). Clients get `metadata`
    with the server's name.
    """

    host: str = DEFAULT_HOST
    port: int = DEFAULT_PORT
    name: str = "rostether"
    token: str = field(default="", repr=False)
    origins: tuple[str, ...] = ()
    allow: tuple[str, ...] = ()
    certificate: str = ""
    key: str = ""
    capabilities: tuple[str, ...] = CAPABILITIES
    metadata: Mapping[str, str] = field(default_factory=dict)
    topics: NameFilter = NameFilter()
    services: NameFilter = NameFilter()
    parameters: NameFilter = NameFilter()
    client_topics: NameFilter = NameFilter()
    limits: FoxgloveLimits = field(default_factory=FoxgloveLimits)
