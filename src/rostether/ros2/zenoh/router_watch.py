"""Whether a session has lost its router. Zenoh does not report it, and finds no new nodes meanwhile."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

import zenoh

# The interval at which a graph of ROS 1 asks its master. A check takes microseconds.
CHECK_S = 1.0


async def watch_router(session: zenoh.Session, named: Sequence[str], report: Callable[[str], None]) -> None:
    """Report the problem when no router is connected, and an empty text when one is connected again.

    Runs until it is cancelled. `named` are the endpoints that the configuration names: one that never
    answered is also a problem, unless other peers are connected: a network of peers needs no router.
    """
    place = f" at {', '.join(named)}" if named else ""
    problem = f"the zenoh router{place} does not answer"
    had_router = False
    while True:
        info = session.info
        has_router = bool(info.routers_zid())
        had_router |= has_router
        is_lost = not has_router and (had_router or (bool(named) and not info.peers_zid()))
        report(problem if is_lost else "")
        await asyncio.sleep(CHECK_S)
