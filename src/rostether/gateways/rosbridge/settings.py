"""What may be set of a rosbridge server, and the limits that hold for every client."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase

from rostether.gateways.websocket.settings import ServerSettings

DEFAULT_PORT = 9090
"""Where roslibjs' examples and every page made for rosbridge look for it."""

DEFAULT_MAX_MESSAGE_BYTES = 10_000_000
"""rosbridge's own default. It holds before anything is parsed, and for what fragments make together."""

MAX_CLIENTS = 1024
"""Pages and programs of a large laboratory; each costs a descriptor and some 100 kB."""

MAX_GREETING = 256
"""Connections that have not said what they want yet; websockets gives each ten seconds for that."""

MAX_SUBSCRIPTIONS = 1000
"""Topics of one client: a page that shows a whole robot has some hundred."""

MAX_PUBLICATIONS = 1000
"""Topics that one client advertises; each is known to the whole graph."""

MAX_SERVICES = 200
"""Services that one client offers; each is known to the whole graph."""

MAX_CALLS = 1024
"""Service calls of one client in flight, and as many of others that it has not answered yet."""

MAX_QUEUED_MESSAGES = 1000
"""What waits of one topic for a client that names no queue length: 10 s of a sensor at 100 Hz."""

MAX_QUEUED_BYTES = 16 << 20
"""What waits for one client altogether, not yet in JSON: a few camera images."""

MAX_CONTROL_BYTES = 64 << 20
"""Answers that wait for a client that does not read: it asked for each, and has hung if they pile up."""

OPERATION_LIMIT_S = 10.0
"""How long a graph may take to advertise or subscribe before an error is reported."""

GREETING_LIMIT_S = 10.0
"""Who has not authenticated by then frees the place."""

PING_PERIOD_S = 20.0
PINGS = 3
"""A client that answers none of them is gone. A slow one answers late, behind what was sent before."""

UNSENT_BYTES = 32 << 10
"""What the socket holds for a slow client; the rest waits in queues that drop their oldest messages."""

TURN_S = 0.005
"""How long one client's work may keep others, boards among them, waiting."""


def matches(name: str, globs: tuple[str, ...] | None) -> bool:
    """Return whether a name is among the globs; None is all names."""
    return globs is None or any(fnmatchcase(name, each) for each in globs)


@dataclass(frozen=True, slots=True)
class RosbridgeSettings(ServerSettings):
    """How a rosbridge server serves.

    Only `path` is served, unless it is empty. Globs limit what clients reach; None is everything.
    """

    port: int = DEFAULT_PORT
    path: str = ""
    max_message_bytes: int = DEFAULT_MAX_MESSAGE_BYTES
    deflate: bool = False
    fragment_bytes: int | None = None
    topics_glob: tuple[str, ...] | None = None
    services_glob: tuple[str, ...] | None = None
    params_glob: tuple[str, ...] | None = None
