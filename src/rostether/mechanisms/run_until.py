"""Runs work until it is done, or until something else ends it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable


async def run_until(work: Awaitable[object], end: Awaitable[object]) -> None:
    """Run `work` until it is done, or cancel it when `end` is; then both have ended.

    Raises the error of `work`, including one that it raises when canceled.
    """
    working = asyncio.ensure_future(work)
    ending = asyncio.ensure_future(end)
    try:
        await asyncio.wait([working, ending], return_when=asyncio.FIRST_COMPLETED)
    finally:
        working.cancel()
        ending.cancel()
        await asyncio.wait([working, ending])
        if not working.cancelled():
            working.result()
