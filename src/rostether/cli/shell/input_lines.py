"""Lines of standard input as they come, whatever it is, without a thread or a change of a terminal's mode."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator

# Commands are short; what is longer is no command.
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
    """Read what is there, waiting for it; a file, or /dev/null, is always ready and cannot be waited for."""
    loop = asyncio.get_running_loop()
    while True:
        ready = asyncio.Event()
        try:
            loop.add_reader(descriptor, ready.set)
        except PermissionError:
            # Without a pause /dev/zero, which has no end, would keep the loop from everything else.
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
    """Tell whether reading would stop us: a command in the background must not read from the terminal."""
    try:
        return not os.isatty(descriptor) or os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        return True  # a terminal that is not ours stops nobody
