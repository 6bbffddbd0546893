"""Starts TLS on an accepted connection.

A listener of asyncio with TLS shows a connection only after its handshake: neither allow lists nor limits
would apply to clients that never finish it.
"""

from __future__ import annotations

import asyncio
import ssl


async def encrypted(
    transport: asyncio.Transport, protocol: asyncio.BaseProtocol, context: ssl.SSLContext, limit_s: float
) -> asyncio.Transport | None:
    """Return the encrypted transport of a client, None if its handshake failed or took longer than the limit.

    Bytes that follow the handshake at once may reach the protocol before this returns.
    """
    try:
        wire = await asyncio.get_running_loop().start_tls(
            transport, protocol, context, server_side=True, ssl_handshake_timeout=limit_s
        )
    except OSError:
        # All errors of ssl, and asyncio's time limit.
        return None
    return None if wire is None or wire.is_closing() else wire
