from __future__ import annotations

import asyncio
from typing import cast

import pytest

from rostether.gateways.rosbridge.outbox import MAX_STATUSES, Due, Outbox, TopicQueue
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection

CONNECTION = cast("PublisherConnection", None)


def batch(*payloads: bytes) -> Batch:
    return Batch(CONNECTION, payloads)


def put(outbox: Outbox, queue: TopicQueue, *payloads: bytes) -> None:
    whole = batch(*payloads)
    for index in range(len(payloads)):
        outbox.put(queue, whole, index)


def drain(outbox: Outbox) -> list[str | bytes]:
    """Take everything that is there: answers as they are, messages as their payloads."""
    taken: list[str | bytes] = []
    while (item := outbox.next()) is not None:
        taken.append(item.batch.payloads[item.index] if isinstance(item, Due) else item)
    return taken


def test_answers_and_messages_leave_in_the_order_of_their_arrival() -> None:
    outbox, first, second = Outbox(1000, 1000), TopicQueue(10), TopicQueue(10)
    put(outbox, first, b"1")
    outbox.answer("a")
    put(outbox, second, b"2")
    put(outbox, first, b"3")
    assert drain(outbox) == [b"1", "a", b"2", b"3"]
    assert outbox.topic_bytes == 0


def test_a_full_topic_loses_its_oldest_and_no_other_topic_does() -> None:
    outbox, fast, slow = Outbox(1000, 1000), TopicQueue(2), TopicQueue(10)
    put(outbox, slow, b"s")
    put(outbox, fast, b"1", b"2", b"3", b"4")
    put(outbox, slow, b"t")
    assert drain(outbox) == [b"s", b"3", b"4", b"t"]
    assert (fast.dropped_count, slow.dropped_count) == (2, 0)


def test_bytes_are_bounded_and_one_message_is_always_kept() -> None:
    outbox, queue = Outbox(10, 1000), TopicQueue(1000)
    put(outbox, queue, *(b"%d" % digit for digit in range(10)))
    put(outbox, queue, b"x" * 100)
    assert outbox.topic_bytes == 100
    put(outbox, queue, b"y" * 8)
    assert drain(outbox) == [b"y" * 8]
    assert queue.dropped_count == 11


def test_a_line_does_not_grow_with_what_was_pushed_out() -> None:
    outbox, queue = Outbox(100, 1000), TopicQueue(1000)
    for _ in range(50):
        put(outbox, queue, *[b"s"] * 90)
        put(outbox, queue, b"L" * 99)
    assert queue.places <= 100
    taken = drain(outbox)
    assert taken[-1] == b"L" * 99


def test_a_topic_that_is_discarded_leaves_nothing_behind() -> None:
    outbox, gone, kept = Outbox(1000, 1000), TopicQueue(10), TopicQueue(10)
    put(outbox, gone, b"1", b"2")
    put(outbox, kept, b"3")
    outbox.discard(gone)
    assert drain(outbox) == [b"3"]
    assert outbox.topic_bytes == 0


def test_statuses_beyond_the_bound_are_left_out() -> None:
    outbox = Outbox(1000, 1 << 20)
    for number in range(MAX_STATUSES + 10):
        outbox.answer(str(number), is_status=True)
    outbox.answer("answer")
    taken = drain(outbox)
    assert len(taken) == MAX_STATUSES + 1
    assert taken[-1] == "answer"
    outbox.answer("again", is_status=True)
    assert drain(outbox) == ["again"]


def test_who_leaves_too_many_answers_is_given_up() -> None:
    outbox = Outbox(1000, 10)
    outbox.answer("x" * 100)
    assert not outbox.is_overflowing
    outbox.answer("y")
    assert outbox.is_overflowing
    assert drain(outbox) == []


async def test_waiting_ends_with_what_comes_and_where_nothing_more_is_kept() -> None:
    outbox, queue = Outbox(1000, 10), TopicQueue(1)
    waiting = asyncio.ensure_future(outbox.wait())
    await asyncio.sleep(0)
    put(outbox, queue, b"1")
    await waiting
    assert drain(outbox) == [b"1"]
    waiting = asyncio.ensure_future(outbox.wait())
    await asyncio.sleep(0)
    assert not waiting.done()
    outbox.answer("x" * 10)
    outbox.answer("y")
    await waiting
    await outbox.wait()


@pytest.mark.parametrize("length", [0, -3])
def test_a_queue_holds_one_message_at_least(length: int) -> None:
    assert TopicQueue(length).length == 1
