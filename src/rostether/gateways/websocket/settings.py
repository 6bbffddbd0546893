"""The address of a WebSocket server, its access rules, and its limits."""

from __future__ import annotations

from msgspec import Struct

DEFAULT_HOST = "localhost"


class ConnectionLimits(Struct, frozen=True):
    """Limits of one server and its connections."""

    # Open WebSockets.
    clients: int

    # Other connections: unfinished handshakes, and requests for files.
    others: int

    # The size of one message of a client.
    message_bytes: int

    # Data that waits in the socket for a slow client before its user must pause.
    unsent_bytes: int

    # The time for a connection to send its request.
    handshake_s: float = 10.0

    # The time between pings; a client that has disappeared occupies a connection for up to two of these
    # periods.
    ping_period_s: float = 20.0

    # A client that leaves this number of pings unanswered, and reads nothing, has disconnected.
    pings: int = 1


class ServedProtocol(Struct, frozen=True):
    """The protocol that a server speaks over its WebSockets."""

    # The prefix of log lines, such as `foxglove`.
    name: str

    # The WebSocket subprotocols, the best first.
    subprotocols: tuple[str, ...] = ()

    # Whether messages are compressed for clients that support it.
    deflates: bool = False

    # The only path for WebSockets; empty for all paths.
    path: str = ""

    # The web site of a viewer; its pages, and a copy of it on this machine, may connect.
    viewer_site: str = ""

    # Whether a handshake without the token is refused; otherwise the `ConnectionUser` checks the token.
    wants_token_first: bool = True


class ServerSettings(Struct, frozen=True):
    """The address and the access rules of a server.

    `host` is a name or address of this machine; `localhost` is both loopback addresses. Clients must send
    `token` if it is not empty; clients with `view_token` may only view. `origins` are additional web pages
    that may connect (`*`: all). `allow` are the networks that may connect (none: all). With the files
    `certificate` and `key`, connections are encrypted (wss).
    """

    host: str = DEFAULT_HOST
    port: int = 0
    token: str = ""
    origins: tuple[str, ...] = ()
    allow: tuple[str, ...] = ()
    certificate: str = ""
    key: str = ""
    view_token: str = ""

    def __repr__(self) -> str:
        # Omits the tokens, because logs may show this text.
        return f"{type(self).__name__}({self.host!r}, {self.port})"
