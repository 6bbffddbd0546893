"""Converts large CDR outside the event loop: texts and big-endian numbers take 0.25 s per MB."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from rostether.errors import SerializationError

# Converting fewer bytes takes at most 15 ms in the event loop.
LARGE_BYTES = 64 * 1024

FromCdr: TypeAlias = Callable[[bytes], bytes]


class Converted(NamedTuple):
    """A large message that the receiving thread has converted: its payload, or why there is none."""

    payload: bytes
    error: SerializationError | None


Received: TypeAlias = bytes | Converted


def convert_if_large(from_cdr: FromCdr, cdr: bytes) -> Received:
    """Convert a large message in this thread, which is the middleware's; return a small one unchanged."""
    if len(cdr) < LARGE_BYTES:
        return cdr
    try:
        return Converted(from_cdr(cdr), None)
    except SerializationError as error:
        return Converted(b"", error)


def payload_of(from_cdr: FromCdr, received: Received) -> bytes:
    """Return the payload of a received message, in the event loop. Raises SerializationError."""
    if isinstance(received, bytes):
        return from_cdr(received)
    if received.error is not None:
        raise received.error
    return received.payload


async def convert(from_cdr: FromCdr, cdr: bytes) -> bytes:
    """Return the payload of a request or response; convert a large one in a thread.

    Raises SerializationError.
    """
    if len(cdr) < LARGE_BYTES:
        return from_cdr(cdr)
    return await asyncio.to_thread(from_cdr, cdr)
