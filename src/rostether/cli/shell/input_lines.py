"""Reads lines of standard input as they arrive, from a terminal, pipe or file, without a thread."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator

# Commands are short; a longer line is not a command.
MAX_LINE_BYTES = 1 << 16
_READ_BYTES = 1 << 16
_BACKGROUND_S = 1.0
_FILE_PAUSE_S = 0.01


async def input_lines() -> AsyncIterator[str]:
    """Yield the lines of standard input until its end; none where there is no input."""
    if sys.stdin is None or sys.stdin.closed:
        return
    descriptor = sys.stdin.fileno()
    rest = b""
    while chunk := await _read(descriptor):
        *lines, rest = (rest + chunk).split(b"\n")
        for line in lines:
            yield line.decode(errors="replace")
        rest = rest[:MAX_LINE_BYTES]
    if rest:
        yield rest.decode(errors="replace")


async def _read(descriptor: int) -> bytes:
    """Wait for input and read it; a file, or /dev/null, is always ready and cannot be watched."""
    loop = asyncio.get_running_loop()
    while True:
        ready = asyncio.Event()
        try:
            loop.add_reader(descriptor, ready.set)
        except PermissionError:
            # Without a pause, endless input such as /dev/zero would block the loop.
            await asyncio.sleep(_FILE_PAUSE_S)
            break
        try:
            await ready.wait()
        finally:
            loop.remove_reader(descriptor)
        if _may_read(descriptor):
            break
        await asyncio.sleep(_BACKGROUND_S)
    try:
        return os.read(descriptor, _READ_BYTES)
    except OSError:
        return b""


def _may_read(descriptor: int) -> bool:
    """Return whether reading would stop us: a background command must not read from a terminal."""
    try:
        return not os.isatty(descriptor) or os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        return True  # a terminal of another session does not stop us
