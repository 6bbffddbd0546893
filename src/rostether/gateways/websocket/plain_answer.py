"""Answers plain HTTP requests on the port of a WebSocket server: one response, then the connection ends."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import nullcontext
from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from rostether.gateways.websocket.site import Site, refusal

# Longer than any HTTP method.
MAX_METHOD_BYTES = 16

# The size of one read of a download.
_CHUNK_BYTES = 256 << 10

# Long enough for a phone on a weak network to read the largest file of the page.
_FILE_S = 30.0


class PlainAnswer:
    """The answer on one connection.

    `has_room` is set while the client reads fast enough; `set_limit` gets the time after which the connection
    is aborted.
    """

    def __init__(
        self, transport: asyncio.Transport, has_room: asyncio.Event, set_limit: Callable[[float], None]
    ) -> None:
        self._transport = transport
        self._has_room = has_room
        self._set_limit = set_limit
        self._download: asyncio.Task[None] | None = None

    @property
    def is_download(self) -> bool:
        """Whether a file is sent in pieces, which continues after the client has ended its side."""
        return self._download is not None

    def send(self, response: Response, limit_s: float) -> None:
        """Send a response; then the client closes the connection."""
        self._transport.write(response.serialize())
        end_sending(self._transport)
        self._set_limit(limit_s)

    def send_file(self, site: Site, request: Request, refused: str | None) -> None:
        """Send a file of the site, or the reason why it is refused."""
        method = request_method(request)
        if refused is not None:
            self.send(refusal(HTTPStatus.FORBIDDEN, refused), _FILE_S)
        elif site.is_download(method, request.path):
            self._set_limit(_FILE_S)
            self._download = asyncio.ensure_future(self._send_download(site, request.path))
        else:
            self.send(site.reply(method, request.path, request.headers), _FILE_S)

    def refuse_malformed(self, site: Site, method: bytes, limit_s: float) -> None:
        """Refuse a request that the library cannot parse, such as one with a body."""
        if method in (b"GET", b"HEAD"):
            response = refusal(HTTPStatus.BAD_REQUEST, "send a GET request without a body")
        else:
            response = site.reply(method.decode(), "/", Headers())
        self.send(response, limit_s)

    def cancel(self) -> None:
        """Stop a download."""
        if self._download is not None:
            self._download.cancel()

    async def _send_download(self, site: Site, path: str) -> None:
        response, file = await asyncio.to_thread(site.open_download, path)
        # A canceled download closes its file.
        with file or nullcontext():
            await self._send_chunk(response.serialize())
            while file is not None and (chunk := await asyncio.to_thread(file.read, _CHUNK_BYTES)):
                await self._send_chunk(chunk)
        # The transport sends written data first.
        self._transport.close()

    async def _send_chunk(self, chunk: bytes) -> None:
        self._transport.write(chunk)
        # A client that reads nothing for this time has disconnected.
        self._set_limit(_FILE_S)
        await self._has_room.wait()


def asks_for_websocket(request: Request) -> bool:
    """Return whether a request asks for an upgrade to WebSocket."""
    return any("websocket" in value.lower() for value in request.headers.get_all("Upgrade"))


def request_method(request: Request) -> str:
    """Return the HTTP method of a request."""
    # Before websockets 17, only GET is parsed, and requests have no method.
    return getattr(request, "method", "GET")


def http_method(start: bytes) -> bytes:
    """Return the HTTP method at the start of a request; empty if this is not HTTP."""
    method = start.partition(b" ")[0]
    return method if method.isalpha() and method.isupper() else b""


def end_sending(transport: asyncio.Transport) -> None:
    """Send the written data, then the end of the stream."""
    # TLS has no half-close; its transport sends written data before it closes.
    if transport.can_write_eof():
        transport.write_eof()
    else:
        transport.close()
