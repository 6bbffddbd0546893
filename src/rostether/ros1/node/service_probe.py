"""Queries a service's server for its type, because the master does not know it."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from typing import TYPE_CHECKING

from rostether.errors import RostetherError, ServiceUnavailableError, UnknownNameError
from rostether.mechanisms.text import did_you_mean, escape_line
from rostether.ros1.environment import parse_rpc_uri
from rostether.ros1.node.node_queries import TOOL_NAME
from rostether.ros1.tcpros_connection import connect
from rostether.tcpros.handshake import MAX_SHOWN_CHARS, probe_fields

if TYPE_CHECKING:
    from rostether.ros1.node.master_client import MasterClient


async def look_up(client: MasterClient, service: str) -> str:
    """Return a service's URI. Raises UnknownNameError with the most similar name."""
    try:
        return await client.lookup_service(service)
    except UnknownNameError:
        raise unknown_service(service, (await client.system_state())[2]) from None


async def provider(client: MasterClient, service: str) -> str:
    """Return the node that offers a service. Raises UnknownNameError."""
    services = (await client.system_state())[2]
    if not services.get(service):
        raise unknown_service(service, services)
    return services[service][0]


def unknown_service(service: str, known: Iterable[str]) -> UnknownNameError:
    """Return the error for a service that no node offers."""
    hint = did_you_mean(service, known) or "`rostether service list` shows all services"
    return UnknownNameError(f"no node offers the service {service}; {hint}")


async def probe_type(client: MasterClient, service: str) -> str:
    """Return a service's type. Raises UnknownNameError, ServiceUnavailableError."""
    return await probe_uri(service, await look_up(client, service))


async def probe_header(service: str, uri: str, *, caller_id: str) -> dict[str, str]:
    """Return the connection header of a service.

    Raises ConfigError for an invalid URI, TransportOpenError, TransportTimeoutError, RemoteProtocolError.
    """
    found: dict[str, str] = {}

    def accept(fields: dict[str, str], transport: asyncio.Transport) -> asyncio.Protocol:
        found.update(fields)
        transport.close()
        return asyncio.Protocol()

    address = parse_rpc_uri(uri, scheme="rosrpc")
    await connect(address.host, address.port, probe_fields(service, caller_id=caller_id), accept)
    return found


async def probe_uri(service: str, uri: str) -> str:
    """Return the type of the service at a URI. Raises ServiceUnavailableError."""
    try:
        found = await probe_header(service, uri, caller_id=TOOL_NAME)
    except RostetherError as error:
        raise ServiceUnavailableError(
            f"service {service} is registered at {uri} but does not answer ({error}); "
            "if its node has ended, `rostether node cleanup` removes it"
        ) from error
    if "error" in found or not found.get("type"):
        reason = escape_line(found.get("error", "no type in its header"), MAX_SHOWN_CHARS)
        raise ServiceUnavailableError(f"the server of {service} does not report its type ({reason})")
    # Old roscpp servers name the request's type.
    return found["type"].removesuffix("Request")
