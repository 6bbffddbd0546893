from __future__ import annotations

import asyncio

from rostether.errors import GraphError
from rostether.gateways.foxglove.client_work import ClientWork


async def test_requests_are_bounded_from_the_moment_they_are_asked() -> None:
    work, failed, go = ClientWork(), list[str](), asyncio.Event()

    async def wait() -> None:
        await go.wait()

    for _ in range(3):
        work.ask(wait, failed.append, 2)
    assert failed == ["more than 2 requests at once; wait for the responses"]
    work.ask(wait, failed.append, 1, "assets")
    assert len(failed) == 1
    go.set()
    await asyncio.gather(*work._tasks)
    work.ask(wait, failed.append, 1)
    await asyncio.gather(*work._tasks)
    assert len(failed) == 1


async def test_what_goes_wrong_is_reported_in_a_line() -> None:
    work, failed = ClientWork(), list[str]()

    async def fail() -> None:
        raise GraphError("not today")

    async def hang() -> None:
        raise TimeoutError

    work.ask(fail, failed.append, 2)
    work.ask(hang, failed.append, 2)
    await asyncio.gather(*work._tasks)
    assert failed == ["not today", "no answer in time; check that the node is running"]


async def test_everything_ends_with_the_client() -> None:
    work, failed = ClientWork(), list[str]()
    work.ask(lambda: asyncio.sleep(1000), failed.append, 1)
    task = work.start(asyncio.sleep(1000))
    work.cancel()
    await asyncio.wait([task])
    assert task.cancelled()
    assert not failed
