"""Long waits are announced, short ones are not."""

from __future__ import annotations

import asyncio

import pytest

from rostether.cli.shell.slow_notice import reported_when_long


async def test_a_long_wait_is_reported_once() -> None:
    reported = asyncio.Queue[str]()
    with reported_when_long(reported.put_nowait, "building", after_s=0):
        async with asyncio.timeout(60):
            assert await reported.get() == "building"
    assert reported.empty()


async def test_a_short_wait_is_not_reported() -> None:
    reported: list[str] = []
    with pytest.raises(KeyError), reported_when_long(reported.append, "building", after_s=0.01):
        raise KeyError
    await asyncio.sleep(0.03)
    assert not reported
