from __future__ import annotations

import ctypes
import threading
from typing import cast

import zenoh

from contract.zenoh_graphs import open_router, open_session
from rostether.ros2.zenoh.thread_state import keep_thread_state
from waiting import until


async def test_a_thread_of_zenoh_keeps_its_state_between_callbacks() -> None:
    receiving, port = await open_router()
    sending = await open_session(port, is_router=False)
    seen: list[tuple[int, bool]] = []
    local = threading.local()

    def take(_: object) -> None:
        keep_thread_state()
        seen.append((threading.get_ident(), hasattr(local, "was_here")))
        local.was_here = True

    receiving.zenoh.declare_subscriber("a", zenoh.handlers.Callback(take, indirect=False))
    publisher = sending.zenoh.declare_publisher("a")
    await until(lambda: cast(zenoh.MatchingStatus, publisher.matching_status).matching)
    for count in range(1, 21):
        publisher.put(b"x")
        await until(lambda: len(seen) == count)  # noqa: B023 - awaited at once
    # The first callback in each thread finds no data, every later one the data of the previous one.
    known: set[int] = set()
    for thread, was_here in seen:
        assert was_here is (thread in known)
        known.add(thread)
    assert len(known) < len(seen)
    await sending.close()
    await receiving.close()


def test_threads_of_python_are_not_affected() -> None:
    def run() -> None:
        for _ in range(3):
            keep_thread_state()

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    keep_thread_state()
    assert ctypes.pythonapi.PyGILState_Check() == 1
