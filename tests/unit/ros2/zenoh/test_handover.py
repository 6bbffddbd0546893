from __future__ import annotations

import asyncio
import ctypes
import threading
from typing import cast

import zenoh

from contract.zenoh_graphs import open_router, open_session
from rostether.ros2.zenoh.handover import Handover, stay_known
from waiting import until


async def test_items_of_a_thread_arrive_in_order_and_in_batches() -> None:
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


async def test_the_oldest_go_when_there_is_too_much() -> None:
    batches: list[list[str]] = []
    handover: Handover[str] = Handover(batches.append, limit=10)
    for item in ("a", "b", "c"):
        handover.put(item, 5)
    await until(lambda: batches)
    assert batches == [["b", "c"]]
    assert handover.dropped_count == 1
    # The newest stays, even alone too large.
    handover.put("d", 1)
    handover.put("e", 11)
    await until(lambda: len(batches) == 2)
    assert batches[1] == ["e"]


async def test_a_pause_keeps_what_comes() -> None:
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


async def test_nothing_is_handed_on_after_the_end() -> None:
    batches: list[list[int]] = []
    handover: Handover[int] = Handover(batches.append, limit=3)
    handover.put(1)
    handover.close()
    handover.put(2)
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert batches == []


def test_a_loop_that_has_ended_is_no_error() -> None:
    async def make() -> Handover[int]:
        return Handover(lambda _: None, limit=3)

    handover = asyncio.run(make())
    handover.put(1)
    handover.put(2)


async def test_a_thread_of_zenohs_keeps_its_state_between_callbacks() -> None:
    receiving, port = await open_router()
    sending = await open_session(port, is_router=False)
    seen: list[tuple[int, bool]] = []
    local = threading.local()

    def take(_: object) -> None:
        stay_known()
        seen.append((threading.get_ident(), hasattr(local, "was_here")))
        local.was_here = True

    receiving.zenoh.declare_subscriber("a", zenoh.handlers.Callback(take, indirect=False))
    publisher = sending.zenoh.declare_publisher("a")
    await until(lambda: cast(zenoh.MatchingStatus, publisher.matching_status).matching)
    for count in range(1, 21):
        publisher.put(b"x")
        await until(lambda: len(seen) == count)  # noqa: B023 - awaited at once
    # The first callback in each thread finds nothing, every later one what the one before left.
    known: set[int] = set()
    for thread, was_here in seen:
        assert was_here is (thread in known)
        known.add(thread)
    assert len(known) < len(seen)
    await sending.close()
    await receiving.close()


def test_it_harms_no_thread_of_pythons_own() -> None:
    def run() -> None:
        for _ in range(3):
            stay_known()

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    stay_known()
    assert ctypes.pythonapi.PyGILState_Check() == 1
