"""Peers with raw sockets: they send exactly the bytes of a test, correct or not."""

from __future__ import annotations

import asyncio
import contextlib
import struct
from collections.abc import AsyncIterator, Callable, Mapping
from dataclasses import dataclass, field

from contract.graphs import STRING
from rostether.ros1.xmlrpc_server import XmlRpcServer
from rostether.tcpros.handshake import publisher_fields, subscriber_fields
from rostether.tcpros.header import decode_fields, encode_header
from rostether.transports.sockets import close_servers
from waiting import until

__all__ = ["STRING", "FakePublisher", "RawPeer", "until"]


@dataclass
class RawPeer:
    """A TCP connection that a test drives by hand."""

    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter

    @classmethod
    async def connect(cls, port: int, *, limit: int = 1 << 16) -> RawPeer:
        """Connect to a port of loopback."""
        return cls(*await asyncio.open_connection("127.0.0.1", port, limit=limit))

    @classmethod
    @contextlib.asynccontextmanager
    async def subscribing(cls, port: int, topic: str, **fields: str) -> AsyncIterator[RawPeer]:
        """Connect and send a subscriber's header, with fields changed."""
        peer = await cls.connect(port)
        peer.send_header(subscriber_fields(topic, STRING, caller_id="/raw", tcp_nodelay=False) | fields)
        try:
            yield peer
        finally:
            await peer.close()

    def send_header(self, fields: Mapping[str, str]) -> None:
        """Send a connection header."""
        self.writer.write(encode_header(fields))

    async def read_header(self) -> dict[str, str]:
        """Read a connection header."""
        (length,) = struct.unpack("<I", await self.reader.readexactly(4))
        return decode_fields(await self.reader.readexactly(length))

    async def read_message(self) -> bytes:
        """Read one message."""
        (length,) = struct.unpack("<I", await self.reader.readexactly(4))
        return await self.reader.readexactly(length)

    async def read_answer(self) -> tuple[int, bytes]:
        """Read a service's answer."""
        ok, length = struct.unpack("<BI", await self.reader.readexactly(5))
        return ok, await self.reader.readexactly(length)

    async def is_hung_up(self) -> bool:
        """Wait until the other side disconnects; return False if it sends something instead."""
        try:
            return await asyncio.wait_for(self.reader.read(1), 60) == b""
        except ConnectionError:
            return True

    async def close(self) -> None:
        """Disconnect."""
        self.writer.close()
        with contextlib.suppress(ConnectionError):
            await self.writer.wait_closed()


@dataclass
class FakePublisher:
    """A publisher's slave API and TCPROS port; `answer` is what requestTopic returns."""

    topic: str = "/chat"
    header: dict[str, str] = field(
        default_factory=lambda: publisher_fields("/chat", STRING, caller_id="/fake", latch=False)
    )
    peers: list[RawPeer] = field(default_factory=list)
    requests: list[dict[str, str]] = field(default_factory=list)
    asked: int = 0
    port: int = 0
    uri: str = ""
    answer: Callable[[FakePublisher], object] = lambda self: [1, "", ["TCPROS", "127.0.0.1", self.port]]

    async def __aenter__(self) -> FakePublisher:
        self._server = await asyncio.start_server(self._take, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        self._api = XmlRpcServer({"requestTopic": self._request_topic})
        await self._api.start()
        self.uri = self._api.uri
        return self

    async def __aexit__(self, *_: object) -> None:
        await close_servers([self._server])
        for peer in self.peers:
            await peer.close()
        await self._server.wait_closed()
        await self._api.close()

    def _request_topic(self, _caller_id: str, _topic: str, _protocols: object) -> object:
        self.asked += 1
        return self.answer(self)

    async def _take(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        peer = RawPeer(reader, writer)
        self.requests.append(await peer.read_header())
        peer.send_header(self.header)
        self.peers.append(peer)
