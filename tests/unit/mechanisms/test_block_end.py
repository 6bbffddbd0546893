from __future__ import annotations

import asyncio

import pytest

from rostether.mechanisms.block_end import closed_at_end, task_beside


class Opened:
    is_closed = False

    async def close(self) -> None:
        self.is_closed = True


async def test_it_is_closed_after_the_block_and_after_an_error() -> None:
    async with closed_at_end(Opened()) as opened:
        assert not opened.is_closed
    assert opened.is_closed
    failing = Opened()
    with pytest.raises(ValueError, match="in the block"):
        async with closed_at_end(failing):
            raise ValueError("in the block")
    assert failing.is_closed


async def test_the_task_has_ended_when_the_block_has() -> None:
    events: list[str] = []

    async def work() -> None:
        events.append("runs")
        try:
            await asyncio.Event().wait()
        finally:
            await asyncio.sleep(0)
            events.append("ended")

    async with task_beside(work()):
        await asyncio.sleep(0)
        assert events == ["runs"]
    assert events == ["runs", "ended"]


async def test_an_error_of_the_task_does_not_end_the_block() -> None:
    async def fail() -> None:
        raise ValueError("in the task")

    async with task_beside(fail()) as task:
        await asyncio.sleep(0)
        assert task.done()
