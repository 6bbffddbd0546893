"""Passes the boards of dashboard pages from the dashboard's server to the bridge."""

from __future__ import annotations

from collections.abc import Callable

from rostether.transports.address import WebAddress
from rostether.transports.web import WebSocket, WebTransport
from rostether.transports.web_hello import WebHello

# Enough for a classroom with one robot; each board is a node.
MAX_WEB_BOARDS = 32


class WebBoards:
    """All boards that pages connect; the dashboard's server opens their connections.

    It is also the bridge's `Listener` for these boards.
    """

    def __init__(self, max_boards: int = MAX_WEB_BOARDS) -> None:
        self._max_boards = max_boards
        self._transports: dict[WebTransport, None] = {}
        self._address = WebAddress()
        self._on_transport: Callable[[WebTransport], None] | None = None

    @property
    def address(self) -> str:
        """The link address."""
        return str(self._address)

    def listen(self, address: WebAddress, on_transport: Callable[[WebTransport], None]) -> None:
        """Call back with each new board, until `close`."""
        self._address, self._on_transport = address, on_transport

    def open(self, socket: WebSocket) -> WebTransport:
        """Return the transport of a page's new connection; the page names its board next."""
        return WebTransport(socket, self._connect, self._forget)

    async def close(self) -> None:
        """End all transports, and refuse new ones. Idempotent."""
        self._on_transport = None
        for transport in list(self._transports):
            transport.close()

    def _connect(self, transport: WebTransport, hello: WebHello) -> str | None:
        if self._on_transport is None:
            return "the bridge is not running; try again later"
        for other in list(self._transports):
            # The page connects again before its old connection is known to be dead: the board keeps its name.
            if other.hello is not None and other.hello.key == hello.key:
                other.close()
        if len(self._transports) >= self._max_boards:
            return f"the limit of boards on pages ({self._max_boards}) is reached; disconnect another board"
        self._transports[transport] = None
        transport.admit(self._address, hello)
        self._on_transport(transport)
        return None

    def _forget(self, transport: WebTransport) -> None:
        self._transports.pop(transport, None)
