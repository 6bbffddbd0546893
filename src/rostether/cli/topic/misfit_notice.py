"""Reports messages that do not have their type's layout on stderr, many of them in one line."""

from __future__ import annotations

import asyncio
from contextlib import aclosing, asynccontextmanager
from typing import TYPE_CHECKING, Any

from rostether.cli.shell.output import warn
from rostether.mechanisms.rate_limits import RepeatLimiter
from rostether.mechanisms.text import misfit_text

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, AsyncIterator

    from rostether.errors import SerializationError
    from rostether.graph.message_stream import MessageStream


@asynccontextmanager
async def shown_messages(stream: MessageStream[Any]) -> AsyncIterator[AsyncGenerator[Any, None]]:
    """Yield a stream's messages; those that cannot be decoded are counted on stderr.

    The first of these is reported immediately, later ones every 10 s and at the end of the block.
    """
    reported_count = 0
    reason = ""
    # A publisher with a wrong definition sends hundreds a second, and all have the same fault.
    limiter = RepeatLimiter()

    def report() -> None:
        nonlocal reported_count
        reported_count = stream.misfit_count
        warn(f"WARNING: {stream.topic}: {misfit_text(reported_count)} and cannot be shown: {reason}")

    def on_misfit(error: SerializationError) -> None:
        nonlocal reason
        reason = str(error)
        if limiter.admit("misfit", asyncio.get_running_loop().time()) is not None:
            report()

    stream.on_misfit = on_misfit
    async with aclosing(aiter(stream)) as messages:
        try:
            yield messages
        finally:
            if stream.misfit_count > reported_count:
                report()
