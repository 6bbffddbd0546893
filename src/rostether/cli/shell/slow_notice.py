"""Telling what we are waiting for, where it takes long enough to look like standing still."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LONG_S = 1.5
"""A cached sketch and a built simulator are there sooner; the first time of both takes ten seconds."""


@contextmanager
def told_when_long(tell: Callable[[str], None], text: str, *, after_s: float = LONG_S) -> Iterator[None]:
    """Tell the text once if what is done inside is not over by then. In a running event loop."""
    telling = asyncio.get_running_loop().call_later(after_s, tell, text)
    try:
        yield
    finally:
        telling.cancel()
