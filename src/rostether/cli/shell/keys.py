"""Keys of a terminal, read as they are pressed."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager

from rostether.cli.shell.input import is_background_job

# A held key repeats thirty times a second, with three bytes each time.
_READ_BYTES = 1024


@contextmanager
def typed_keys(on_typed: Callable[[bytes], None]) -> Iterator[bool]:
    """Call `on_typed` with the bytes of pressed keys until the block ends; then restore the terminal.

    Empty bytes mean that the terminal was closed. Yields False, and reads nothing, if standard input is not a
    terminal, belongs to another job of the shell, or cannot be read key by key (Windows).
    """
    try:
        import termios
        import tty
    except ImportError:
        yield False
        return
    if not sys.stdin.isatty() or is_background_job(sys.stdin.fileno()):
        yield False
        return
    stdin = sys.stdin.fileno()
    loop = asyncio.get_running_loop()

    def read() -> None:
        with contextlib.suppress(BlockingIOError, InterruptedError):
            typed = os.read(stdin, _READ_BYTES)
            if not typed:
                loop.remove_reader(stdin)
            on_typed(typed)

    before = termios.tcgetattr(stdin)
    try:
        tty.setcbreak(stdin)
        loop.add_reader(stdin, read)
        yield True
    finally:
        loop.remove_reader(stdin)
        with contextlib.suppress(termios.error):
            termios.tcsetattr(stdin, termios.TCSADRAIN, before)


def split_keys(typed: bytes, known: Collection[bytes]) -> list[bytes]:
    """Return the keys in the bytes from a terminal; each byte that is not part of a known key is separate."""
    longest = max(map(len, known))
    keys, at = [], 0
    while at < len(typed):
        length = next(
            (each for each in range(min(longest, len(typed) - at), 1, -1) if typed[at : at + each] in known),
            1,
        )
        keys.append(typed[at : at + length])
        at += length
    return keys
