from __future__ import annotations

import asyncio
from typing import cast

from rostether.gateways.rosbridge.outbox import MAX_STATUSES, Due, Outbox
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection
from rostether.gateways.websocket.topic_queues import MESSAGE_COST_BYTES, TURN_BYTES

CONNECTION = cast("PublisherConnection", None)


class Topic:
    def __init__(self) -> None:
        self.dropped_count = 0


def put(outbox: Outbox[Topic], topic: Topic, *payloads: bytes, max_messages: int = 1000) -> None:
    whole = Batch(CONNECTION, payloads)
    for index in range(len(payloads)):
        outbox.put(topic, whole, index, max_messages)


def drain(outbox: Outbox[Topic]) -> list[str | bytes]:
    """Return everything that waits: answers as they are, messages as their payloads."""
    found: list[str | bytes] = []
    while (item := outbox.next()) is not None:
        found.append(item.batch.payloads[item.index] if isinstance(item, Due) else item)
    return found


def test_answers_leave_in_their_order_before_messages_and_topics_in_turn() -> None:
    outbox, first, second = Outbox[Topic](1_000_000, 1000), Topic(), Topic()
    image = bytes(TURN_BYTES)
    put(outbox, first, image, b"2")
    outbox.answer("a")
    put(outbox, second, b"1")
    outbox.answer("b")
    assert drain(outbox) == ["a", "b", image, b"1", b"2"]


def test_a_full_topic_loses_its_oldest_and_no_other_topic_does() -> None:
    outbox, fast, slow = Outbox[Topic](1000, 1000), Topic(), Topic()
    put(outbox, slow, b"s")
    put(outbox, fast, b"1", b"2", b"3", b"4", max_messages=2)
    put(outbox, slow, b"t")
    assert drain(outbox) == [b"s", b"t", b"3", b"4"]
    assert (fast.dropped_count, slow.dropped_count) == (2, 0)


def test_bytes_are_bounded_and_one_message_is_always_kept() -> None:
    outbox, topic = Outbox[Topic](10 * MESSAGE_COST_BYTES, 1000), Topic()
    put(outbox, topic, *(b"%d" % digit for digit in range(9)))
    put(outbox, topic, b"x" * 5000)
    assert topic.dropped_count == 9
    assert drain(outbox) == [b"x" * 5000]


def test_a_topic_that_is_discarded_leaves_nothing_behind() -> None:
    outbox, gone, kept = Outbox[Topic](1000, 1000), Topic(), Topic()
    put(outbox, gone, b"1", b"2")
    put(outbox, kept, b"3")
    outbox.discard(gone)
    assert drain(outbox) == [b"3"]


def test_statuses_beyond_the_bound_are_skipped() -> None:
    outbox = Outbox[Topic](1000, 1 << 20)
    for number in range(MAX_STATUSES + 10):
        outbox.answer(str(number), is_status=True)
    outbox.answer("answer")
    found = drain(outbox)
    assert len(found) == MAX_STATUSES + 1
    assert found[-1] == "answer"
    outbox.answer("again", is_status=True)
    assert drain(outbox) == ["again"]


def test_a_client_that_leaves_too_many_answers_overflows() -> None:
    outbox = Outbox[Topic](1000, 10)
    outbox.answer("x" * 100)
    assert not outbox.is_overflowing
    outbox.answer("y")
    assert outbox.is_overflowing
    assert drain(outbox) == []


async def test_waiting_ends_with_what_comes_and_where_nothing_more_is_kept() -> None:
    outbox, topic = Outbox[Topic](1000, 10), Topic()
    waiting = asyncio.ensure_future(outbox.wait())
    await asyncio.sleep(0)
    put(outbox, topic, b"1")
    await waiting
    assert drain(outbox) == [b"1"]
    waiting = asyncio.ensure_future(outbox.wait())
    await asyncio.sleep(0)
    assert not waiting.done()
    outbox.answer("x" * 10)
    outbox.answer("y")
    await waiting
    await outbox.wait()
