"""Shows the reason for a wait that is long enough to look like a hang."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# A cached sketch and a built simulator start sooner; the first build of both takes ten seconds.
LONG_S = 1.5


@contextmanager
def reported_when_long(
    report: Callable[[str], None], text: str, *, after_s: float = LONG_S
) -> Iterator[None]:
    """Report the text once if the block takes longer than `after_s`. Needs a running event loop."""
    reporting = asyncio.get_running_loop().call_later(after_s, report, text)
    try:
        yield
    finally:
        reporting.cancel()
