"""A network that delivers the end of each long message to the node late, as TCP does after a loss."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

# The delay of a packet that is lost twice.
LATE_S = 0.8
PACKET_BYTES = 100


@asynccontextmanager
async def late_network(address: str) -> AsyncIterator[str]:
    """Forward connections to a bridge at `tcp://HOST:PORT`; yield the address `HOST:PORT` of the network."""
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    tasks: set[asyncio.Task[None]] = set()

    async def forward(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, pause_s: float) -> None:
        try:
            while data := await reader.read(1 << 16):
                for first in range(0, len(data), PACKET_BYTES):
                    if first:
                        await asyncio.sleep(pause_s)
                    writer.write(data[first : first + PACKET_BYTES])
        finally:
            writer.close()

    async def connect(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        bridge_reader, bridge_writer = await asyncio.open_connection(host, port)
        for task in (forward(reader, bridge_writer, 0.0), forward(bridge_reader, writer, LATE_S)):
            tasks.add(asyncio.ensure_future(task))

    server = await asyncio.start_server(connect, "127.0.0.1", 0)
    try:
        yield f"127.0.0.1:{server.sockets[0].getsockname()[1]}"
    finally:
        server.close()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
