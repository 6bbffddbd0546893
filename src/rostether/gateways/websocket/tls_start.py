"""Starts TLS on an accepted connection.

asyncio reports a connection of a TLS listener only after its handshake, so allow lists and limits would not
apply to clients that never finish it.
"""

from __future__ import annotations

import asyncio
import os
import socket
import ssl
from typing import cast

from rostether.transports.tls import clear_handshake

_PLAIN_TEXT = b"This port is encrypted: use https:// instead of http://, and wss:// instead of ws://\n"
_PLAIN_ANSWER = (
    b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\n"
    b"Content-Length: %d\r\nConnection: close\r\n\r\n%b" % (len(_PLAIN_TEXT), _PLAIN_TEXT)
)


async def encrypted(
    transport: asyncio.Transport,
    protocol: asyncio.BaseProtocol,
    early: bytearray,
    context: ssl.SSLContext,
    limit_s: float,
) -> asyncio.Transport | None:
    """Return the encrypted transport of a client, None if its handshake failed or took longer than the limit.

    `early` holds the bytes that the protocol has received, and is emptied. Bytes directly after the handshake
    may reach the protocol before this returns. A request without TLS gets an answer that names https.
    """
    # The server has ended the connection to make room. asyncio would wait for its handshake until the limit,
    # with a buffer of 256 KiB.
    if transport.is_closing():
        return None
    loop = asyncio.get_running_loop()
    try:
        # asyncio closes its socket if the handshake fails, so the answer to plain HTTP needs another one.
        with socket.socket(fileno=os.dup(transport.get_extra_info("socket").fileno())) as spare:
            received = bytes(early)
            early.clear()
            # uvloop ignores a pause in connection_made, and reads before TLS starts. asyncio replaces the
            # protocol now, and connects it in the next iteration.
            if received:
                loop.call_soon(loop.call_soon, _feed, transport, received)
            try:
                wire = await loop.start_tls(
                    transport, protocol, context, server_side=True, ssl_handshake_timeout=limit_s
                )
            except ssl.SSLError as error:
                clear_handshake(error)
                if error.reason == "HTTP_REQUEST":
                    spare.send(_PLAIN_ANSWER)
                return None
    except OSError as error:
        # asyncio's time limit, a client that has disconnected, and too many open files.
        clear_handshake(error)
        transport.abort()
        return None
    return None if wire is None or wire.is_closing() else wire


def _feed(transport: asyncio.Transport, received: bytes) -> None:
    if transport.is_closing():
        return
    # uvloop's protocols are not subclasses of asyncio's.
    tls = cast(asyncio.BufferedProtocol, transport.get_protocol())
    memoryview(tls.get_buffer(len(received)))[: len(received)] = received
    tls.buffer_updated(len(received))
