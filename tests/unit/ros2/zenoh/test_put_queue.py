from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import pytest

from rostether.errors import SerializationError
from rostether.graph.flow_control import STEPS
from rostether.ros2.zenoh.put_queue import LONG_NS, VERY_LONG_NS, BatchResult, PutQueue
from waiting import until


class Link:
    """A link that has room when the test allows it."""

    def __init__(self) -> None:
        self.room = threading.Event()
        self.put: list[bytes] = []
        self.threads: set[int] = set()
        self.noted: list[BatchResult] = []
        self.error: Exception | None = None

    def take(self, payloads: Sequence[bytes]) -> BatchResult:
        self.threads.add(threading.get_ident())
        self.room.wait(60)
        if self.error is not None:
            raise self.error
        self.put += payloads
        return BatchResult(len(payloads))

    def note(self, puts: BatchResult) -> None:
        assert threading.current_thread() is threading.main_thread()
        self.noted.append(puts)


@pytest.fixture
def threads() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(1) as executor:
        yield executor


def payloads(count: int, size: int = 1000) -> list[bytes]:
    return [b"%06d" % number + bytes(size - 6) for number in range(count)]


async def test_a_thread_waits_for_room_and_the_loop_continues(threads: ThreadPoolExecutor) -> None:
    link = Link()
    queue = PutQueue(link.take, link.note, threads, 1 << 20)
    assert queue.is_idle
    sent = payloads(200)
    queue.add(sent[:100])
    queue.add(sent[100:])
    assert not queue.is_idle
    await until(lambda: link.threads)
    assert not link.put
    link.room.set()
    await until(lambda: queue.is_idle)
    assert link.put == sent
    assert threading.get_ident() not in link.threads
    assert sum(puts.done for puts in link.noted) == 200


async def test_messages_added_while_a_thread_puts_are_put_afterwards(threads: ThreadPoolExecutor) -> None:
    link = Link()
    link.room.set()
    queue = PutQueue(link.take, link.note, threads, 1 << 20)
    sent = payloads(500, 10)
    for payload in sent:
        queue.add([payload])
        await asyncio.sleep(0)
    await until(lambda: queue.is_idle)
    assert link.put == sent


async def test_the_oldest_messages_are_dropped_beyond_the_limit(threads: ThreadPoolExecutor) -> None:
    link = Link()
    queue = PutQueue(link.take, link.note, threads, 100_000)
    sent = payloads(400)
    queue.add(sent[:1])
    queue.add(sent[1:])
    assert queue.dropped_count == 299
    assert not queue.flow.is_open
    for _ in range(STEPS + 2):
        await queue.flow.drained(0.0)
    assert queue.flow.is_open, "a full link pauses no publisher for long"
    link.room.set()
    await until(lambda: queue.is_idle)
    assert link.put == [*sent[:1], *sent[-100:]]


async def test_after_a_long_put_a_thread_is_used_for_some_time(
    threads: ThreadPoolExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = Link()
    link.room.set()
    queue = PutQueue(link.take, link.note, threads, 1 << 20)
    queue.note_longest(VERY_LONG_NS)
    queue.add(payloads(1))
    await until(lambda: link.noted)
    assert not queue.is_idle
    monkeypatch.setattr("rostether.ros2.zenoh.put_queue.THREAD_IN_USE_S", 0.5)
    queue.note_longest(VERY_LONG_NS)
    assert not queue.is_idle
    await until(lambda: queue.is_idle)


async def test_a_thread_is_used_after_two_rather_long_puts_but_not_after_one(
    threads: ThreadPoolExecutor,
) -> None:
    queue = PutQueue(Link().take, Link().note, threads, 1 << 20)
    queue.note_longest(LONG_NS - 1)
    queue.note_longest(LONG_NS)
    assert queue.is_idle
    queue.note_longest(LONG_NS)
    assert not queue.is_idle
    await queue.finish()


async def test_waiting_messages_are_put_at_the_end(threads: ThreadPoolExecutor) -> None:
    link = Link()
    link.room.set()
    queue = PutQueue(link.take, link.note, threads, 1 << 20)
    sent = payloads(500)
    queue.add(sent)
    await queue.finish()
    assert link.put == sent


async def test_the_end_does_not_wait_for_a_link_that_hangs(
    threads: ThreadPoolExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.ros2.zenoh.put_queue.FINISH_LIMIT_S", 0.01)
    link = Link()
    queue = PutQueue(link.take, link.note, threads, 1 << 20)
    queue.add(payloads(500))
    await queue.finish()
    assert queue.dropped_count > 400
    link.room.set()


async def test_a_publisher_that_has_ended_does_not_stop_the_queue(threads: ThreadPoolExecutor) -> None:
    link = Link()
    link.room.set()
    link.error = SerializationError("undeclared")
    queue = PutQueue(link.take, link.note, threads, 1 << 20)
    queue.add(payloads(3))
    await until(lambda: queue.is_idle)
    assert not link.noted
