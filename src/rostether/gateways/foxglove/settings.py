"""Settings of a gateway for Foxglove: its address, its clients, and how much of the graph it serves."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rostether.errors import ConfigError
from rostether.gateways.foxglove.limits import FoxgloveLimits
from rostether.gateways.websocket.settings import ServerSettings

# The default port of Foxglove.
DEFAULT_PORT = 8765

# The capabilities of clients besides reading topics; simulated time is also sent.
CAPABILITIES = (
    "clientPublish",
    "parameters",
    "parametersSubscribe",
    "services",
    "connectionGraph",
    "assets",
)


@dataclass(frozen=True, slots=True)
class NameFilter:
    """The offered names: those that fully match a pattern; None offers every name."""

    patterns: tuple[re.Pattern[str], ...] | None = None

    @classmethod
    def of(cls, expressions: Iterable[str], source: str) -> NameFilter:
        """Compile regular expressions; `source` names their origin. Raises ConfigError."""
        try:
            return cls(tuple(re.compile(each) for each in expressions))
        except re.error as error:
            raise ConfigError(f"{source}: {error.pattern!r} is not a regular expression: {error}") from None

    def includes(self, name: str) -> bool:
        """Return whether a name is offered."""
        return self.patterns is None or any(pattern.fullmatch(name) for pattern in self.patterns)


@dataclass(frozen=True, slots=True)
class FoxgloveSettings(ServerSettings):
    """How a gateway serves.

    `name` is the server's in the clients' windows, `metadata` is sent with it; log lines start with `label`.
    The filters limit what
    clients reach.
    """

    port: int = DEFAULT_PORT
    name: str = "rostether"
    label: str = "foxglove"
    capabilities: tuple[str, ...] = CAPABILITIES
    metadata: Mapping[str, str] = field(default_factory=dict)
    topics: NameFilter = NameFilter()
    services: NameFilter = NameFilter()
    parameters: NameFilter = NameFilter()
    client_topics: NameFilter = NameFilter()
    limits: FoxgloveLimits = field(default_factory=FoxgloveLimits)
