from __future__ import annotations

import asyncio

from rostether.bridge.reading_pause import ReadingPause
from unit.bridge.doubles import FakeTransport, until


class PausableTransport(FakeTransport):
    is_paused = False

    def pause_reading(self) -> None:
        self.is_paused = True

    def resume_reading(self) -> None:
        self.is_paused = False


async def test_everybody_who_asked_is_waited_for() -> None:
    transport = PausableTransport()
    pause = ReadingPause(transport)
    first, second = asyncio.Event(), asyncio.Event()
    assert pause.until(first.wait)
    assert transport.is_paused
    await asyncio.sleep(0)
    assert pause.until(second.wait)
    first.set()
    await asyncio.sleep(0.01)
    assert transport.is_paused
    second.set()
    await until(lambda: not transport.is_paused, "reading to go on")


async def test_a_link_that_cannot_pause_is_not_waited_for() -> None:
    transport = PausableTransport(can_pause=False)
    assert not ReadingPause(transport).until(asyncio.Event().wait)
    assert not transport.is_paused


async def test_closing_waits_for_nobody() -> None:
    transport = PausableTransport()
    pause = ReadingPause(transport)
    pause.until(asyncio.Event().wait)
    await asyncio.sleep(0)
    pause.close()
    await until(lambda: not transport.is_paused, "reading to go on")
