from __future__ import annotations

import asyncio

from rostether.bridge.outbound.reading_pause import ReadingPause
from unit.bridge.doubles import FakeTransport
from waiting import until


class PausableTransport(FakeTransport):
    is_paused = False

    def pause_reading(self) -> None:
        self.is_paused = True

    def resume_reading(self) -> None:
        self.is_paused = False


def no_failure(error: Exception) -> None:
    raise AssertionError(f"a wait failed: {error}")


async def test_all_requests_are_awaited() -> None:
    transport = PausableTransport()
    pause = ReadingPause(transport, no_failure)
    first, second = asyncio.Event(), asyncio.Event()
    assert pause.pause_until(first.wait)
    assert transport.is_paused
    await asyncio.sleep(0)
    assert pause.pause_until(second.wait)
    first.set()
    await asyncio.sleep(0.01)
    assert transport.is_paused
    second.set()
    await until(lambda: not transport.is_paused, "reading to go on")


async def test_a_link_that_cannot_pause_is_not_waited_for() -> None:
    transport = PausableTransport(can_pause=False)
    assert not ReadingPause(transport, no_failure).pause_until(asyncio.Event().wait)
    assert not transport.is_paused


async def test_closing_does_not_wait() -> None:
    transport = PausableTransport()
    pause = ReadingPause(transport, no_failure)
    pause.pause_until(asyncio.Event().wait)
    await asyncio.sleep(0)
    pause.close()
    await until(lambda: not transport.is_paused, "reading to go on")


async def test_a_wait_that_fails_is_reported_and_the_others_are_waited_for() -> None:
    async def fail() -> None:
        raise KeyError("drained")

    failed: list[Exception] = []
    transport = PausableTransport()
    pause = ReadingPause(transport, failed.append)
    other = asyncio.Event()
    assert pause.pause_until(fail)
    assert pause.pause_until(other.wait)
    await until(lambda: asyncio.all_tasks() - {asyncio.current_task()}, "the waits")
    for _ in range(10):
        await asyncio.sleep(0)
    assert transport.is_paused
    other.set()
    await until(lambda: not transport.is_paused, "reading to go on")
    assert [str(error) for error in failed] == ["'drained'"]
    assert pause.pause_until(other.wait)
    await until(lambda: not transport.is_paused, "reading to go on again")
