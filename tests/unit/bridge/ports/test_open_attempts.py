from __future__ import annotations

import asyncio

import pytest

from rostether.bridge.ports.link_keeper import OpenAttempts
from rostether.mechanisms.backoff import Backoff


@pytest.fixture
def waits(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    waits: list[float] = []

    async def sleep(delay_s: float) -> None:
        waits.append(delay_s)

    monkeypatch.setattr(asyncio, "sleep", sleep)
    return waits


async def test_each_new_reason_is_reported_once(waits: list[float]) -> None:
    reports: list[str] = []
    attempts = OpenAttempts(Backoff(first_s=1.0, limit_s=4.0, jitter=0.0), reports.append, settle_s=0.0)
    for reason in ("busy", "busy", "no permission", "busy"):
        await attempts.wait_after(reason)
    assert reports == ["busy", "no permission", "busy"]
    assert waits == [1.0, 2.0, 4.0, 4.0]


@pytest.mark.usefixtures("waits")
async def test_a_port_that_has_just_appeared_may_refuse(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = asyncio.get_running_loop()
    now_s = loop.time()
    reports: list[str] = []
    attempts = OpenAttempts(Backoff(first_s=0.001, limit_s=0.001), reports.append, settle_s=3600.0)
    await attempts.wait_after("no permission")
    assert reports == []
    monkeypatch.setattr(loop, "time", lambda: now_s + 4000.0)
    await attempts.wait_after("no permission")
    assert reports == ["no permission"]
