from __future__ import annotations

import asyncio

import pytest

from rostether.gateways.foxglove import data_outlet
from rostether.gateways.foxglove.data_outlet import DataOutlet

SIZE = 100_000


@pytest.mark.parametrize(("is_latched", "count"), [(False, 1), (True, 3)])
async def test_only_latched_messages_may_be_old(
    monkeypatch: pytest.MonkeyPatch, is_latched: bool, count: int
) -> None:
    monkeypatch.setattr(data_outlet, "_MAX_AGE_S", 0.0)
    written = bytearray()
    dropped: list[int] = []
    outlet = DataOutlet(10_000_000, written.extend, dropped.append)
    outlet.pause()
    for number in range(3):
        outlet.send(1, 0, [bytes([number]) * SIZE], is_latched=is_latched)
        await asyncio.sleep(0.002)
    outlet.resume()
    assert len(written) // SIZE == count
    assert written.endswith(bytes([2]) * SIZE)
    assert sum(dropped) == 3 - count
