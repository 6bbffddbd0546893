"""Listens on one port of several addresses of this machine, for the servers of a master and of nodes."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Callable, Sequence

from rostether.errors import ConfigError, GraphError
from rostether.ros1.environment import connect_host
from rostether.transports.sockets import close_servers, start_server

# A free port of one address is rarely in use on another one; repeated clashes have another cause.
_ATTEMPTS = 5

# Accepting all waiting connections in one turn of the loop would delay others.
_ACCEPTED_AT_ONCE = 128


async def start_servers(
    make_protocol: Callable[[], asyncio.Protocol], hosts: Sequence[str], port: int
) -> list[asyncio.Server]:
    """Listen on the same port of all hosts; port 0 means a free one.

    Raises GraphError if the port is in use, ConfigError if a host is not an address of this machine.
    """
    addresses = [connect_host(host) for host in hosts]
    attempt = 1
    while True:
        servers: list[asyncio.Server] = []
        try:
            for address in addresses:
                common_port = port_of(servers) if servers else port
                servers.append(
                    await start_server(
                        make_protocol, address, common_port, accepted_at_once=_ACCEPTED_AT_ONCE
                    )
                )
        except asyncio.CancelledError:
            await close_servers(servers)
            raise
        except OSError as error:
            await close_servers(servers)
            if port or error.errno != errno.EADDRINUSE or attempt == _ATTEMPTS:
                raise _explain(", ".join(addresses), port, error) from error
            attempt += 1
        else:
            return servers


def port_of(servers: Sequence[asyncio.Server]) -> int:
    """Return the port of the servers of `start_servers`."""
    port: int = servers[0].sockets[0].getsockname()[1]
    return port


def _explain(addresses: str, port: int, error: OSError) -> GraphError | ConfigError:
    if error.errno == errno.EADDRNOTAVAIL:
        return ConfigError(
            f"cannot listen on {addresses}: not an address of this machine; check ROS_IP, ROS_HOSTNAME and "
            "--listen"
        )
    if port and error.errno == errno.EADDRINUSE:
        return GraphError(
            f"port {port} of {addresses} is in use; stop the program that uses it, or choose another port"
        )
    if port and error.errno == errno.EACCES:
        return GraphError(f"port {port} of {addresses} is reserved for the system; choose one above 1023")
    return GraphError(
        f"cannot listen on {addresses}: {error.strerror}; check ROS_IP, ROS_HOSTNAME and --listen"
    )
