"""The settings of a rosbridge server, and the limits of every client."""

from __future__ import annotations

from fnmatch import fnmatchcase

from rostether.errors import AccessDeniedError
from rostether.gateways.websocket.settings import ConnectionLimits, ServerSettings

# The default port of rosbridge, which pages and examples use.
DEFAULT_PORT = 9090

# Topics of one client: a page that shows a whole robot has about a hundred.
MAX_SUBSCRIPTIONS = 1000

# Topics that one client advertises; each is known to the whole graph.
MAX_PUBLICATIONS = 1000

# Services that one client offers; each is known to the whole graph.
MAX_SERVICES = 200

# The limit of pending service calls of one client, and of calls to it that it has not answered. A page has a
# few at a time.
MAX_CALLS = 1024

# Active goals of one client; a robot executes a few at a time.
MAX_GOALS = 100

# Actions that one client offers; each is three services and two topics of the graph.
MAX_ACTIONS = 50

# The waiting messages of one topic without a queue length: 10 s of a sensor at 100 Hz.
MAX_QUEUED_MESSAGES = 1000

# All waiting messages of one client, not yet in JSON: a few camera images.
MAX_QUEUED_BYTES = 16 << 20

# The waiting answers of one client: it requested each, and has hung if they pile up.
MAX_CONTROL_BYTES = 64 << 20

# How long a graph may take to advertise or subscribe before an error is reported.
OPERATION_LIMIT_S = 10.0

# A client that has not authenticated within this time is disconnected.
GREETING_LIMIT_S = 10.0

# How long one client's work may delay others, including boards.
TURN_S = 0.005


def check_allowed(name: str, globs: tuple[str, ...] | None, parameter: str) -> None:
    """Raise AccessDeniedError for a name that matches none of the globs of the server's parameter."""
    if not matches(name, globs):
        raise AccessDeniedError(
            f"this server does not let clients use {name}; add it to the server's parameter ~{parameter}"
        )


def matches(name: str, globs: tuple[str, ...] | None) -> bool:
    """Return whether a name matches one of the globs; None matches all names."""
    return globs is None or any(fnmatchcase(name, each) for each in globs)


class RosbridgeLimits(ConnectionLimits, frozen=True):
    """Bounds of one server and its connections."""

    # Enough for the pages and programs of a large laboratory; each needs a descriptor and about 100 kB.
    clients: int = 1024

    # Connections that have not sent a request yet; each has ten seconds for it.
    others: int = 256

    # rosbridge's own default. It applies before parsing, and to joined fragments.
    message_bytes: int = 10_000_000

    # Further messages wait in queues that drop the oldest.
    unsent_bytes: int = 32 << 10

    # A client that answers no ping has disconnected. A slow client answers late, after it has read earlier
    # data. One that has disappeared is noticed after 60 to 80 s.
    pings: int = 3


class RosbridgeSettings(ServerSettings, frozen=True):
    """The settings of a rosbridge server.

    Only `path` is served, unless it is empty. Clients can only use names that match the globs; None allows
    all names.
    """

    port: int = DEFAULT_PORT
    path: str = ""
    deflate: bool = False
    fragment_bytes: int | None = None
    topics_glob: tuple[str, ...] | None = None
    services_glob: tuple[str, ...] | None = None
    params_glob: tuple[str, ...] | None = None
    limits: RosbridgeLimits = RosbridgeLimits()
