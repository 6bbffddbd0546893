"""The configuration of zenoh sessions: like rmw_zenoh's, but on loopback, and with a built-in router.

Like ROS 2 processes, a session is a peer that finds other peers on this machine through the router at
tcp/localhost:7447. If no router answers there, the session becomes the router.
"""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Sequence
from pathlib import Path

import zenoh

from rostether.errors import ConfigError
from rostether.mechanisms.text import fold_line
from rostether.ros2.environment import Ros2Environment
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

ROUTER_PORT = 7447
ROUTER_ENDPOINT = f"tcp/localhost:{ROUTER_PORT}"
_ALL_ADDRESSES = ("/0.0.0.0:", "/[::]:")
# A local router accepts a connection within a millisecond, or within this time if the machine swaps.
PROBE_TIMEOUT_S = 1.0

# How long a put waits for room on a full link: as long as a slow subscriber may pause a board. This is enough
# for a process that is not scheduled for a moment. Zenoh does not wait for this link again until it has sent
# something.
WAIT_BEFORE_DROP_US = 100_000

_SHARED = {
    "scouting/multicast/enabled": "false",
    "scouting/gossip/enabled": "true",
    # No delay is needed: without multicast, there is no scouting.
    "scouting/delay": "0",
    # Latched messages are stored by timestamp.
    "timestamping/enabled": "{router: true, peer: true, client: true}",
    # In ms, as in rmw_zenoh's configuration: service calls may take minutes.
    "queries_default_timeout": "600000",
    # 16 batches of 64 KiB for each link: a burst from a board never fills the queue.
    "transport/link/tx/queue/size/data": "16",
    # A put to a full queue waits for room first; see publication.py.
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
_JSON_ERROR = re.compile(r'JSON error: Message { msg: "(.*)", location: .* line: (\d+), column: (\d+) .*')


async def is_router_there(endpoint: str = ROUTER_ENDPOINT) -> bool:
    """Return whether something accepts connections at a tcp or tls endpoint; True for other protocols."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    if protocol not in ("tcp", "tls") or not port.isdecimal():
        return True  # There is no cheap check, and the user has configured this endpoint.
    try:
        async with asyncio.timeout(PROBE_TIMEOUT_S):
            _, writer = await asyncio.open_connection(host.strip("[]"), int(port))
    except (OSError, TimeoutError):
        return False
    writer.close()
    return True


def peer_configuration(environment: Ros2Environment, reach: ZenohReach) -> zenoh.Config:
    """Return the configuration of a session that connects to a router. Raises ConfigError."""
    if environment.zenoh_session_config is not None:
        return _override(_from_file(environment.zenoh_session_config), environment, reach)
    settings = {**_SHARED, **_PEER, "connect/endpoints": json.dumps([ROUTER_ENDPOINT])}
    return _override(_from_settings(settings), environment, reach)


def router_configuration(environment: Ros2Environment, reach: ZenohReach) -> zenoh.Config:
    """Return the configuration of a session that is the router. Raises ConfigError."""
    if environment.zenoh_router_config is not None:
        return _override(_from_file(environment.zenoh_router_config), environment, reach)
    # With `always` and explicit endpoints, a second router may run on the same machine.
    is_elsewhere = reach.router is RouterChoice.ALWAYS and reach.listen
    endpoints = [] if is_elsewhere else [ROUTER_ENDPOINT]
    settings = {**_SHARED, **_ROUTER, "listen/endpoints": json.dumps(endpoints)}
    return _override(_from_settings(settings), environment, reach)


def configures_endpoints(environment: Ros2Environment) -> bool:
    """Return whether the user's own configuration sets the mode or the endpoints of a session."""
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


def _override(configuration: zenoh.Config, environment: Ros2Environment, reach: ZenohReach) -> zenoh.Config:
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
    """Return zenoh's error without the source location, line breaks and Rust's notation of values."""
    text = fold_line(str(error).partition(" at /")[0])
    return _JSON_ERROR.sub(r"\1 (line \2, column \3)", text)
