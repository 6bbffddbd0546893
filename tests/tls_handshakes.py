"""Counts TLS handshakes in memory: each has a read buffer of 256 KiB."""

from __future__ import annotations

import gc
from asyncio.sslproto import SSLProtocol
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager


@asynccontextmanager
async def handshakes_in_memory() -> AsyncIterator[Callable[[], int]]:
    """Yield a function that counts them, without garbage collections, which would free those in cycles."""
    gc.collect()
    gc.disable()
    try:
        yield lambda: sum(isinstance(each, SSLProtocol) for each in gc.get_objects())
    finally:
        gc.enable()
