"""YAML documents that come through a pipe, each as soon as it is complete."""

from __future__ import annotations

import asyncio
import os
import stat
from collections.abc import AsyncIterator
from typing import TextIO

from rostether.errors import ConfigError

SEPARATOR = "---"

MAX_LINE_BYTES = 64 << 20
"""Longer than any message in the field as text; without a limit a pipe could fill memory."""


async def piped_documents(stream: TextIO) -> AsyncIterator[str]:
    """Yield the text of each document at the `---` that ends it, the last one at the end; no empty ones.

    The loop goes on while a pipe is silent. Raises ConfigError for a line beyond all measure.
    """
    lines: list[str] = []
    async for line in _lines(stream):
        if line.rstrip() != SEPARATOR:
            lines.append(line)
            continue
        if text := _joined(lines):
            yield text
        lines.clear()
    if text := _joined(lines):
        yield text


def _joined(lines: list[str]) -> str:
    text = "".join(lines)
    return text if text.strip() else ""


async def _lines(stream: TextIO) -> AsyncIterator[str]:
    descriptor = _pipe_descriptor(stream)
    if descriptor is None:
        # Files and /dev/null never keep anyone waiting, and the loop cannot watch them.
        for line in stream:
            yield line
        return
    reader = asyncio.StreamReader(limit=MAX_LINE_BYTES)
    transport, _ = await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(os.dup(descriptor), "rb")
    )
    try:
        while line_bytes := await reader.readline():
            yield line_bytes.decode("utf-8", "surrogateescape")
    except ValueError:
        raise ConfigError(f"the pipe holds a line of more than {MAX_LINE_BYTES} bytes") from None
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
