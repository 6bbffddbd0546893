"""Reads YAML documents from a pipe, each as soon as it is complete."""

from __future__ import annotations

import asyncio
import os
import stat
from collections.abc import AsyncIterator
from typing import TextIO

from rostether.errors import ConfigError

SEPARATOR = "---"

# Larger than any usual message as text; without a limit a pipe could fill memory.
MAX_DOCUMENT_BYTES = 64 << 20


async def piped_documents(stream: TextIO) -> AsyncIterator[str]:
    """Yield the text of each document at its closing `---`, the last one at the end; skip empty ones.

    The event loop keeps running while a pipe is silent. Raises ConfigError for a document that is too large.
    """
    lines: list[str] = []
    size = 0
    async for line in _lines(stream):
        if line.rstrip() != SEPARATOR:
            lines.append(line)
            size += len(line)
            if size > MAX_DOCUMENT_BYTES:
                raise _too_long()
            continue
        if text := _joined(lines):
            yield text
        lines.clear()
        size = 0
    if text := _joined(lines):
        yield text


def _too_long() -> ConfigError:
    return ConfigError(
        f"a YAML document is larger than {MAX_DOCUMENT_BYTES} bytes; separate messages with {SEPARATOR}"
    )


def _joined(lines: list[str]) -> str:
    text = "".join(lines)
    return text if text.strip() else ""


async def _lines(stream: TextIO) -> AsyncIterator[str]:
    descriptor = _pipe_descriptor(stream)
    if descriptor is None:
        # Files and /dev/null are always ready, and the loop cannot watch them.
        while line := stream.readline(MAX_DOCUMENT_BYTES + 1):
            yield line
        return
    reader = asyncio.StreamReader(limit=MAX_DOCUMENT_BYTES)
    transport, _ = await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(os.dup(descriptor), "rb")
    )
    try:
        while line_bytes := await reader.readline():
            yield line_bytes.decode("utf-8", "surrogateescape")
    except ValueError:
        raise _too_long() from None
    finally:
        transport.close()
        # The next command of a shell's `(a; b) < pipe` has the same open pipe.
        os.set_blocking(descriptor, True)


def _pipe_descriptor(stream: TextIO) -> int | None:
    if os.name == "nt":
        return None
    try:
        descriptor = stream.fileno()
    except (OSError, AttributeError):
        return None
    mode = os.fstat(descriptor).st_mode
    return descriptor if stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode) else None
