from __future__ import annotations

import asyncio
from typing import Any

import pytest

from rostether.mechanisms.tasks import cancel_all, occurs_within, run_until, start_task


async def test_a_task_is_kept_until_it_ends() -> None:
    tasks: set[asyncio.Task[Any]] = set()
    end = asyncio.Event()
    task = start_task(tasks, end.wait())
    await asyncio.sleep(0)
    assert tasks == {task}
    end.set()
    assert await task
    await asyncio.sleep(0)
    assert not tasks


async def test_all_cancelled_tasks_have_ended_and_their_errors_are_ignored() -> None:
    tasks: set[asyncio.Task[Any]] = set()

    async def fail_at_the_end() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            raise ValueError("at the end")

    started = [start_task(tasks, fail_at_the_end()), start_task(tasks, asyncio.sleep(60))]
    await asyncio.sleep(0)
    await cancel_all(*tasks)
    assert all(task.done() for task in started)
    assert not tasks


async def test_the_wait_for_an_event_has_a_limit() -> None:
    event = asyncio.Event()
    assert not await occurs_within(event, 0.01)
    asyncio.get_running_loop().call_soon(event.set)
    assert await occurs_within(event, 10.0)
    assert await occurs_within(event, None)


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
