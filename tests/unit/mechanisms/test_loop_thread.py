from __future__ import annotations

import asyncio
import concurrent.futures
import os
import threading
import warnings
from collections.abc import Callable

import pytest

from rostether.errors import GraphError
from rostether.mechanisms import loop_thread
from rostether.mechanisms.loop_thread import LoopThread, in_own_loop, run_in_thread


@pytest.fixture(scope="module")
def loop() -> LoopThread:
    return LoopThread(InterruptedError)


def test_results_and_errors_come_back(loop: LoopThread) -> None:
    async def add(left: int, right: int) -> int:
        await asyncio.sleep(0)
        return left + right

    async def fail() -> None:
        raise KeyError("x")

    assert loop.call(add(1, 2)) == 3
    with pytest.raises(KeyError):
        loop.call(fail())


def in_fork(call: Callable[[], object]) -> bool:
    """Return whether a call in a forked process raises GraphError."""
    with warnings.catch_warnings(action="ignore", category=DeprecationWarning):
        child = os.fork()
    if child == 0:
        try:
            call()
        except GraphError:
            os._exit(0)
        finally:
            os._exit(1)
    return os.waitpid(child, 0)[1] == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows does not fork")
def test_a_forked_process_gets_an_error_instead_of_waiting_forever(loop: LoopThread) -> None:
    loop.call(asyncio.sleep(0))
    assert in_fork(lambda: loop.call(asyncio.sleep(0)))
    assert in_fork(lambda: loop.post(print))
    assert not loop.is_lost
    assert not in_fork(lambda: LoopThread().call(asyncio.sleep(0)))


def test_a_limit(loop: LoopThread) -> None:
    with pytest.raises(TimeoutError):
        loop.call(asyncio.sleep(30), timeout_s=0.01)


def test_calls_that_last_longer_than_one_wait(loop: LoopThread, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop_thread, "_SHORT_WAIT_S", 0.001)

    async def wait_and_fail() -> None:
        await asyncio.sleep(0.02)
        raise TimeoutError("its own")

    assert loop.call(asyncio.sleep(0.02, "done")) == "done"
    with pytest.raises(TimeoutError, match="its own"):
        loop.call(wait_and_fail())
    with pytest.raises(TimeoutError):
        loop.call(asyncio.sleep(30), timeout_s=0.01)


def test_waiting_is_interrupted(loop: LoopThread) -> None:
    started = threading.Event()

    async def wait() -> None:
        started.set()
        await asyncio.sleep(30)

    def interrupt() -> None:
        started.wait()
        loop.interrupt()

    threading.Thread(target=interrupt).start()
    with pytest.raises(InterruptedError):
        loop.call(wait())


def test_posted_functions_run_in_order(loop: LoopThread) -> None:
    seen: list[int] = []
    for number in range(50):
        loop.post(seen.append, number)
    loop.call(asyncio.sleep(0))
    assert seen == list(range(50))


def test_handlers_may_wait_for_one_another(loop: LoopThread) -> None:
    count = 40
    barrier = threading.Barrier(count)

    async def run() -> list[int]:
        return await asyncio.gather(*(run_in_thread(barrier.wait) for _ in range(count)))

    assert sorted(loop.call(run(), timeout_s=60)) == list(range(count))


@pytest.mark.parametrize(
    "error", [SystemExit(3), KeyboardInterrupt(), concurrent.futures.CancelledError(), StopIteration()]
)
def test_what_ends_a_handler_ends_neither_its_caller_nor_the_program(
    loop: LoopThread, error: BaseException
) -> None:
    def leave() -> None:
        raise error

    with pytest.raises(RuntimeError, match=type(error).__name__):
        loop.call(run_in_thread(leave), timeout_s=10)
    assert loop.call(run_in_thread(lambda: 5)) == 5


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
