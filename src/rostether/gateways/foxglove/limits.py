"""What a gateway for Foxglove bounds, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass

from rostether.gateways.websocket.settings import ConnectionLimits


@dataclass(frozen=True, slots=True)
class FoxgloveLimits:
    """Bounds of one gateway and its clients."""

    clients: int = 64
    """A class in front of one robot; each may cost `waiting_bytes`."""

    others: int = 32
    """Connections beside clients: a page asks for some ten files at once, a few pages are loaded together."""

    message_bytes: int = 16 << 20
    """Of what a client sends: a large image or map that it publishes."""

    waiting_bytes: int = 32 << 20
    """For each slow client: some five camera images, or seconds of everything else."""

    control_bytes: int = 32 << 20
    """Answers that a client does not read; then it is given up. Large ones wait for their turn."""

    asset_bytes: int = 64 << 20
    """The largest meshes that robots have are some ten megabytes."""

    calls: int = 32
    """Service calls and parameter requests of one client at once, as Foxglove's own server takes."""

    assets: int = 1024
    """Asked for by one client at once, read one after another: all meshes of a robot's description."""

    subscriptions: int = 4096
    """Of one client: more topics than any graph has."""

    client_channels: int = 256
    """Topics that one client publishes."""

    watched_parameters: int = 1024
    """Of one client; on ROS 2 each is asked for."""

    handshake_s: float = 10.0
    """Until a connection must have said that it is a WebSocket."""

    ping_period_s: float = 20.0
    """A client that has not answered until the next ping, and reads nothing, is gone."""

    call_timeout_s: float = 60.0
    """A service that takes longer than a person waits; Foxglove itself has no limit."""

    parameters_timeout_s: float = 10.0
    """For an answer about parameters; a node that hangs on ROS 2 must not hold up all."""

    def of_connections(self, unsent_bytes: int) -> ConnectionLimits:
        """Return the limits of the WebSocket server; `unsent_bytes` is what the socket of a client holds."""
        return ConnectionLimits(
            clients=self.clients,
            others=self.others,
            message_bytes=self.message_bytes,
            unsent_bytes=unsent_bytes,
            handshake_s=self.handshake_s,
            ping_period_s=self.ping_period_s,
        )
