"""The configuration of our zenoh sessions: like rmw_zenoh's, on loopback, and as the router if there is none.

A session is a peer that knows the others of this machine through the router at tcp/localhost:7447, as the
processes of ROS 2 are. Where no router answers there, it takes that place itself.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import zenoh

from rostether.errors import ConfigError
from rostether.ros2.environment import Ros2Environment

ROUTER_PORT = 7447
ROUTER_ENDPOINT = f"tcp/localhost:{ROUTER_PORT}"
_ALL_ADDRESSES = ("/0.0.0.0:", "/[::]:")
# A router on this machine accepts within a millisecond; one on a machine that swaps, within this.
PROBE_TIMEOUT_S = 1.0

# How long a full link may hold up the loop, as long as any slow subscriber may pause a board: a process that
# is not scheduled for a while loses nothing. Zenoh does not wait for a link again before that one has sent
# something.
WAIT_BEFORE_DROP_US = 100_000

_SHARED = {
    "scouting/multicast/enabled": "false",
    "scouting/gossip/enabled": "true",
    # There is nothing to wait for: without multicast, no peer is scouted.
    "scouting/delay": "0",
    # Latched topics are kept by timestamp.
    "timestamping/enabled": "{router: true, peer: true, client: true}",
    "queries_default_timeout": "600000",
    # A burst of one chunk of a board never meets a full queue: 16 batches of 64 KiB for each link.
    "transport/link/tx/queue/size/data": "16",
    # A put that meets one waits for room first; meanwhile no more is put, see publication.py.
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": str(WAIT_BEFORE_DROP_US),
}
_PEER = {
    "mode": '"peer"',
    "listen/endpoints": '["tcp/localhost:0"]',
    # A session that starts before the router finds it later.
    "connect/timeout_ms": "{router: -1, peer: -1, client: 0}",
    "connect/exit_on_failure": "{router: false, peer: false, client: true}",
    "connect/retry": "{period_init_ms: 500, period_max_ms: 2000, period_increase_factor: 2}",
}
_ROUTER = {"mode": '"router"', "connect/exit_on_failure": "false"}


class RouterChoice(Enum):
    """Whether a session takes the place of the router."""

    # If none answers.
    AUTO = "auto"
    # Waits for one without a limit.
    NEVER = "never"
    # It fails when the place is taken. Endpoints to listen at are its place instead of the usual one.
    ALWAYS = "always"


@dataclass(frozen=True, slots=True)
class Reach:
    """Where a session connects and listens: endpoints (`tcp/192.168.1.7:7447`) besides the default ones."""

    router: RouterChoice = RouterChoice.AUTO
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()


async def is_router_there(endpoint: str = ROUTER_ENDPOINT) -> bool:
    """Return whether something accepts connections at a tcp endpoint."""
    protocol, _, place = endpoint.partition("/")
    host, _, port = place.rpartition(":")
    if protocol not in ("tcp", "tls") or not port.isdecimal():
        return True  # It cannot be asked cheaply, and who names it means it.
    try:
        async with asyncio.timeout(PROBE_TIMEOUT_S):
            _, writer = await asyncio.open_connection(host.strip("[]"), int(port))
    except (OSError, TimeoutError):
        return False
    writer.close()
    return True


def peer_configuration(environment: Ros2Environment, reach: Reach) -> zenoh.Config:
    """Return the configuration of a session beside a router. Raises ConfigError."""
    if environment.zenoh_session_config is not None:
        return _override(_from_file(environment.zenoh_session_config), environment, reach)
    settings = {**_SHARED, **_PEER, "connect/endpoints": json.dumps([ROUTER_ENDPOINT])}
    return _override(_from_settings(settings), environment, reach)


def router_configuration(environment: Ros2Environment, reach: Reach) -> zenoh.Config:
    """Return the configuration of a session that is the router. Raises ConfigError."""
    if environment.zenoh_router_config is not None:
        return _override(_from_file(environment.zenoh_router_config), environment, reach)
    # With `always` and explicit endpoints, a second router may run beside another one.
    is_elsewhere = reach.router is RouterChoice.ALWAYS and reach.listen
    place = [] if is_elsewhere else [ROUTER_ENDPOINT]
    settings = {**_SHARED, **_ROUTER, "listen/endpoints": json.dumps(place)}
    return _override(_from_settings(settings), environment, reach)


def names_its_own_place(environment: Ros2Environment) -> bool:
    """Return whether the user's own configuration names the endpoints."""
    return environment.zenoh_session_config is not None or any(
        path in ("mode", "connect") or path.startswith("connect/endpoints")
        for path, _ in environment.zenoh_overrides
    )


def _from_file(path: Path) -> zenoh.Config:
    try:
        return zenoh.Config.from_file(str(path))
    except Exception as error:
        raise ConfigError(f"{path} is not a zenoh configuration: {one_line(error)}") from error


def _from_settings(settings: dict[str, str]) -> zenoh.Config:
    configuration = zenoh.Config()
    for path, value in settings.items():
        configuration.insert_json5(path, value)
    return configuration


def _override(configuration: zenoh.Config, environment: Ros2Environment, reach: Reach) -> zenoh.Config:
    _add(configuration, "connect/endpoints", reach.connect)
    _add(configuration, "listen/endpoints", reach.listen)
    for path, value in environment.zenoh_overrides:
        try:
            configuration.insert_json5(path, value)
        except Exception as error:
            raise ConfigError(
                f"ZENOH_CONFIG_OVERRIDE: zenoh does not accept {path}={value:.200}: {one_line(error)}"
            ) from error
    return configuration


def _add(configuration: zenoh.Config, path: str, endpoints: Sequence[str]) -> None:
    if not endpoints:
        return
    known = json.loads(configuration.get_json(path))
    if not isinstance(known, list):
        raise ConfigError(f"the zenoh configuration has {path} for each mode; write the endpoints there")
    wide = {_port(each) for each in endpoints if any(host in each for host in _ALL_ADDRESSES)}
    # All addresses include loopback: listening on both is impossible.
    kept = [each for each in known if not ("localhost" in each and _port(each) in wide)]
    try:
        configuration.insert_json5(path, json.dumps([*kept, *endpoints]))
    except Exception as error:
        raise ConfigError(
            f"zenoh does not accept {path} {', '.join(endpoints)}: {one_line(error)}"
        ) from error


def _port(endpoint: str) -> str:
    return endpoint.rpartition(":")[2]


def one_line(error: BaseException) -> str:
    """Return zenoh's error without the source location and line breaks."""
    return " ".join(str(error).partition(" at /")[0].split())
