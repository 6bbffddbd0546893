from __future__ import annotations

import asyncio
import threading

from rostether.ros2.handover import MAX_BATCH, MAX_BATCH_BYTES, Handover
from waiting import until


async def test_items_from_a_thread_arrive_in_order_and_in_batches() -> None:
    batches: list[list[int]] = []
    handover: Handover[int] = Handover(batches.append, limit=10_000)

    def run() -> None:
        for number in range(1000):
            handover.put(number)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()  # The loop does not turn meanwhile, so there is one batch.
    assert batches == []
    await until(lambda: batches)
    assert batches == [list(range(1000))]
    handover.put(1000)
    await until(lambda: len(batches) == 2)
    assert batches[1] == [1000]


async def test_a_flood_does_not_block_other_work_of_the_loop() -> None:
    batches: list[list[int]] = []
    handover: Handover[int] = Handover(batches.append, limit=10_000)
    for number in range(3 * MAX_BATCH + 1):
        handover.put(number)
    handover.put(-1)
    await until(lambda: batches and batches[-1][-1] == -1)
    assert [len(each) for each in batches] == [MAX_BATCH, MAX_BATCH, MAX_BATCH, 2]
    assert [each for batch in batches for each in batch] == [*range(3 * MAX_BATCH + 1), -1]
    batches.clear()
    large: Handover[int] = Handover(batches.append, limit=10 * MAX_BATCH_BYTES)
    for number in range(4):
        large.put(number, MAX_BATCH_BYTES // 2 + 1)
    await until(lambda: len(batches) == 2)
    assert batches == [[0, 1], [2, 3]]


async def test_the_oldest_items_are_dropped_beyond_the_limit() -> None:
    batches: list[list[str]] = []
    handover: Handover[str] = Handover(batches.append, limit=10)
    for item in ("a", "b", "c"):
        handover.put(item, 5)
    await until(lambda: batches)
    assert batches == [["b", "c"]]
    assert handover.dropped_count == 1
    # The newest item is kept, even if it alone is too large.
    handover.put("d", 1)
    handover.put("e", 11)
    await until(lambda: len(batches) == 2)
    assert batches[1] == ["e"]


async def test_items_are_kept_during_a_pause() -> None:
    batches: list[list[int]] = []
    handover: Handover[int] = Handover(batches.append, limit=3)
    handover.put(1)
    handover.pause()
    for number in (2, 3, 4):
        handover.put(number)
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert batches == []
    handover.resume()
    handover.resume()
    await until(lambda: batches)
    assert batches == [[2, 3, 4]]


async def test_nothing_is_delivered_after_close() -> None:
    batches: list[list[int]] = []
    handover: Handover[int] = Handover(batches.append, limit=3)
    handover.put(1)
    handover.close()
    handover.put(2)
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert batches == []


def test_a_loop_that_has_ended_is_not_an_error() -> None:
    async def make() -> Handover[int]:
        return Handover(lambda _: None, limit=3)

    handover = asyncio.run(make())
    handover.put(1)
    handover.put(2)
