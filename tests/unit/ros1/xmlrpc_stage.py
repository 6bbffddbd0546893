"""A server, a client, and a connection whose bytes a test writes itself."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any

from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from rostether.xmlrpc.http_message import HttpClientSide
from xmlrpc_documents import dump_call, load_response


@contextlib.asynccontextmanager
async def serving(methods: Mapping[str, Callable[..., Any]], **options: Any) -> AsyncIterator[XmlRpcServer]:
    server = XmlRpcServer(methods, **options)
    await server.start()
    try:
        yield server
    finally:
        await server.close()


@contextlib.asynccontextmanager
async def client_of(server: XmlRpcServer) -> AsyncIterator[XmlRpcClient]:
    client = XmlRpcClient(server.uri)
    try:
        yield client
    finally:
        await client.close()


class RawClient:
    """A connection whose bytes a test writes itself."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer

    @classmethod
    async def connect(cls, server: XmlRpcServer) -> RawClient:
        return cls(*await asyncio.open_connection("127.0.0.1", server.port))

    async def answer(self) -> object:
        http = HttpClientSide("localhost")
        http.send_request(b"")
        while True:
            data = await self.reader.read(65536)
            if (body := http.receive_data(data)) is not None:
                return load_response(body)

    async def close(self) -> None:
        self.writer.close()
        with contextlib.suppress(OSError):
            await self.writer.wait_closed()


def request(method: str, *params: object) -> bytes:
    return HttpClientSide("localhost").send_request(dump_call(method, params))


async def later(value: object) -> object:
    await asyncio.sleep(0)
    return value
