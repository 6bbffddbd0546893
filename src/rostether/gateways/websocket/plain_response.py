"""Responses to plain HTTP requests on the port of a WebSocket server."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from rostether.gateways.websocket.site import Reply, Site, refusal

# HTTP methods are not longer.
MAX_METHOD_BYTES = 16

# The size of one read of a download.
_CHUNK_BYTES = 256 << 10


def asks_for_websocket(request: Request) -> bool:
    """Return whether a request asks for an upgrade to WebSocket."""
    return any("websocket" in value.lower() for value in request.headers.get_all("Upgrade"))


def plain_response(reply: Reply) -> Response:
    """Return the library's form of a site's reply; the connection ends with it."""
    headers = Headers(reply.headers)
    if reply.status is not HTTPStatus.NOT_MODIFIED:
        headers["Content-Length"] = str(reply.length)
    headers["Connection"] = "close"
    return Response(reply.status.value, reply.status.phrase, headers, reply.body)


def malformed_reply(site: Site, start: bytes) -> Reply | None:
    """Return the reply to a request that the library does not parse, such as one with a body.

    `start` are its first bytes; None if they are not HTTP.
    """
    method = start.partition(b" ")[0]
    if not method.isalpha() or not method.isupper():
        return None
    if method in (b"GET", b"HEAD"):
        return refusal(HTTPStatus.BAD_REQUEST, "the request is malformed, or has a body")
    return site.reply(method.decode(), "/", Headers())


async def download_chunks(site: Site, path: str) -> AsyncGenerator[bytes, None]:
    """Yield the response to the request of a download: its header, then its file in chunks."""
    reply, file = await asyncio.to_thread(site.open_download, path)
    if file is None:
        yield plain_response(reply).serialize()
        return
    with file:
        yield plain_response(reply).serialize()
        while chunk := await asyncio.to_thread(file.read, _CHUNK_BYTES):
            yield chunk
