"""Where a WebSocket server listens, who may use it, and what it bounds."""

from __future__ import annotations

from dataclasses import dataclass, field

DEFAULT_HOST = "localhost"


@dataclass(frozen=True, slots=True)
class ConnectionLimits:
    """Bounds of one server and its connections, whatever they say."""

    clients: int
    """WebSockets that are open at once."""

    others: int
    """Connections beside them: handshakes that are not finished, and requests for files."""

    message_bytes: int
    """Of one message of a client."""

    unsent_bytes: int
    """Held by the socket for a client that reads slowly, before its user has to wait."""

    handshake_s: float = 10.0
    """Until a connection must have sent its request."""

    ping_period_s: float = 20.0

    pings: int = 1
    """A client that left this number unanswered, and reads nothing, is gone."""


@dataclass(frozen=True, slots=True)
class ServerSettings:
    """How a server is reached.

    `host` is one name or address of this machine, `localhost` both loopback addresses. Clients must give
    `token` where it is not empty; those who give `view_token` instead may only view. `origins` are more web
    pages that may connect (`*`: all), `allow` networks. With a certificate and its key, files, connections
    are encrypted (wss).
    """

    host: str = DEFAULT_HOST
    port: int = 0
    token: str = field(default="", repr=False)
    origins: tuple[str, ...] = ()
    allow: tuple[str, ...] = ()
    certificate: str = ""
    key: str = ""
    view_token: str = field(default="", repr=False)
