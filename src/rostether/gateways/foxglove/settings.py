"""Settings of a gateway for Foxglove: its address, its clients, and how much of the graph it serves."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from msgspec import Struct, field

from rostether.errors import ConfigError
from rostether.gateways.websocket.settings import ConnectionLimits, ServerSettings

# The default port of Foxglove.
DEFAULT_PORT = 8765

# What clients may do besides reading topics. The gateway adds `time` while the clock is simulated.
CAPABILITIES = (
    "clientPublish",
    "parameters",
    "parametersSubscribe",
    "services",
    "connectionGraph",
    "assets",
)


class FoxgloveLimits(ConnectionLimits, frozen=True):
    """Bounds of one gateway and its clients."""

    # A school class with one robot; each client may need `waiting_bytes`.
    clients: int = 64

    # Connections besides clients: a page requests about ten files at once, and several pages may load
    # together.
    others: int = 32

    # The largest message of a client: an image or map that it publishes.
    message_bytes: int = 16 << 20

    # A tenth of a second of weak Wi-Fi; further messages wait in queues where they can be dropped.
    unsent_bytes: int = 64 << 10

    # For each slow client: about five camera images, or several seconds of all other data.
    waiting_bytes: int = 32 << 20

    # Unread responses of a client; above this limit, the client is disconnected. Large responses are sent one
    # by one.
    control_bytes: int = 32 << 20

    # The largest meshes of robots have about ten megabytes; sending 24 takes 40 ms.
    asset_bytes: int = 24 << 20

    # Service calls and parameter requests of one client at once, the same limit as in Foxglove's own server.
    calls: int = 32

    # Waiting requests of one client for files, which are read one after another: all meshes of a robot.
    assets: int = 1024

    # Subscriptions of one client: more than any graph has topics.
    subscriptions: int = 4096

    # Topics that one client publishes; each is known to the whole graph.
    client_channels: int = 256

    # Watched parameters of one client; on ROS 2 each costs a request.
    watched_parameters: int = 1024

    # Longer than a user waits for a service; Foxglove itself has no limit.
    call_timeout_s: float = 60.0

    # The time limit for a request about parameters; a ROS 2 node that hangs must not delay all others.
    parameters_timeout_s: float = 10.0


class NameFilter(Struct, frozen=True):
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


class FoxgloveSettings(ServerSettings, frozen=True):
    """The settings of a gateway.

    Clients show the `name`, and also get the `metadata`. Log lines start with `label`. Clients can only use
    names that the filters include.
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
