from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest

from rostether.simulation.simavr.simulated_board import SimulatedBoard

Start = Callable[..., Awaitable[SimulatedBoard]]


@pytest.fixture
async def start() -> AsyncIterator[Start]:
    """Starts boards without a link and real time, which run only on request and end with the test."""
    async with AsyncExitStack() as stack:

        async def start_board(program: Path, *words: str, **given: Any) -> SimulatedBoard:
            options: dict[str, Any] = {"realtime": False, "paused": True, "link": "none"} | given
            return await stack.enter_async_context(
                await SimulatedBoard.start(program, commands=words, **options)
            )

        yield start_board
