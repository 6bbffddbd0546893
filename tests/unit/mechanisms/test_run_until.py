"""`run_until`: the end of either the work or the other awaitable ends both."""

from __future__ import annotations

import asyncio

import pytest

from rostether.mechanisms.run_until import run_until


async def _note(notes: list[str], note: str) -> None:
    try:
        await asyncio.Event().wait()
    finally:
        notes.append(note)


async def test_the_end_of_each_ends_the_other() -> None:
    notes: list[str] = []
    await run_until(asyncio.sleep(0), _note(notes, "end"))
    await run_until(_note(notes, "work"), asyncio.sleep(0))
    assert notes == ["end", "work"]


async def test_cancelling_the_caller_cancels_both() -> None:
    notes: list[str] = []
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.01):
            await run_until(_note(notes, "work"), _note(notes, "end"))
    assert sorted(notes) == ["end", "work"]


async def test_an_error_of_the_work_is_raised_even_while_it_is_cancelled() -> None:
    async def fail(first: asyncio.Event) -> None:
        try:
            await first.wait()
        finally:
            raise ValueError

    never = asyncio.Event()
    with pytest.raises(ValueError):
        await run_until(fail(never), asyncio.sleep(0))
    never.set()
    with pytest.raises(ValueError):
        await run_until(fail(never), asyncio.Event().wait())
