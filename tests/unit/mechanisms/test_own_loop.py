from __future__ import annotations

import asyncio
import threading

import pytest

from rostether.mechanisms.own_loop import in_own_loop


async def test_work_that_blocks_does_not_hold_the_loop() -> None:
    went_round = threading.Event()

    async def work() -> int:
        assert went_round.wait(60)
        await asyncio.sleep(0)
        return threading.get_ident()

    asyncio.get_running_loop().call_later(0.0, went_round.set)
    assert await in_own_loop(work) != threading.get_ident()


async def test_errors_are_raised() -> None:
    async def work() -> None:
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        await in_own_loop(work)


async def test_a_program_started_by_the_work_ends_with_it() -> None:
    async def work() -> bytes:
        program = await asyncio.create_subprocess_exec("echo", "hello", stdout=asyncio.subprocess.PIPE)
        output, _ = await program.communicate()
        return output

    assert await in_own_loop(work) == b"hello\n"


async def test_cancelling_ends_the_work() -> None:
    began, ended = threading.Event(), threading.Event()

    async def work() -> None:
        began.set()
        try:
            await asyncio.sleep(3600)
        finally:
            ended.set()

    caller = asyncio.create_task(in_own_loop(work))
    async with asyncio.timeout(60):
        while not began.is_set():
            await asyncio.sleep(0.001)
        caller.cancel()
        with pytest.raises(asyncio.CancelledError):
            await caller
    assert ended.is_set()
