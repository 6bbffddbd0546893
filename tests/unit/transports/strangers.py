"""A peer that counts as another machine: its address is different and not trusted."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest

from rostether.transports import allow_list

STRANGER = "127.0.0.2"


def trust_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    """Require permission for loopback addresses too; call it before the listener is made."""
    monkeypatch.setattr(allow_list, "ALWAYS_ALLOWED", ())


@contextlib.asynccontextmanager
async def stranger(port: int) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    """Connect to a port of 127.0.0.1 from 127.0.0.2."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port, local_addr=(STRANGER, 0))
    try:
        yield reader, writer
    finally:
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()


async def is_hung_up(reader: asyncio.StreamReader) -> bool:
    """Return whether the other side ends the connection without a byte."""
    async with asyncio.timeout(60):
        with contextlib.suppress(ConnectionResetError):
            return await reader.read(1) == b""
    return True
