from __future__ import annotations

import asyncio
from typing import Any, cast

import pytest

from rostether.errors import RemoteProtocolError
from rostether.gateways.rosbridge.client_subscription import (
    MAX_REQUESTS,
    MAX_STATUSES,
    MIN_FRAGMENT_BYTES,
    ClientSubscription,
    Compression,
    Delivery,
    Due,
    Outbox,
    merge,
)
from rostether.gateways.rosbridge.request import Request
from rostether.gateways.rosbridge.settings import MAX_QUEUED_MESSAGES
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection
from rostether.gateways.websocket.topic_queues import MESSAGE_COST_BYTES, TURN_BYTES
from rostether.graph.message_stream import LearnedTypes
from unit.bridge.virtual_time import on_virtual_time

STRING = PublisherConnection("/a", {"type": "std_msgs/String"}, cast("LearnedTypes", None))


def delivery(**fields: Any) -> Delivery:
    return Delivery.read(Request({"op": "subscribe", **fields}))


def subscription(**fields: Any) -> tuple[ClientSubscription, Outbox, list[str]]:
    errors: list[str] = []
    outbox = Outbox(1 << 20, 1 << 20)
    made = ClientSubscription("/a", outbox, errors.append)
    made.add_request(None, delivery(**fields), str(fields.get("type", "")))
    return made, outbox, errors


def take(made: ClientSubscription, *payloads: bytes) -> None:
    made.enqueue(Batch(STRING, payloads))


def sent(outbox: Outbox) -> list[bytes]:
    found = []
    while isinstance(item := outbox.next(), Due):
        found.append(item.batch.payloads[item.index])
    return found


def test_what_a_subscribe_message_asks_for() -> None:
    assert delivery() == Delivery(0.0, 0, None, Compression.NONE)
    assert delivery(throttle_rate=100, queue_length=3, fragment_size=1000, compression="png") == Delivery(
        0.1, 3, 1000, Compression.PNG
    )
    assert delivery(throttle_rate=None, compression=None) == Delivery()
    assert delivery(fragment_size=1).fragment_bytes == MIN_FRAGMENT_BYTES
    with pytest.raises(RemoteProtocolError, match="queue_length"):
        delivery(queue_length=-1)


def test_several_wishes_of_one_client_are_all_met() -> None:
    assert merge(
        [
            Delivery(0.1, 5, 500, Compression.PNG),
            Delivery(0.0, 10, None),
            Delivery(0.2, 1, 100),
        ]
    ) == Delivery(0.0, 1, 100, Compression.PNG)


def test_requests_are_withdrawn_one_by_one_or_all() -> None:
    made, _, _ = subscription(throttle_rate=1000)
    made.add_request("b", delivery(throttle_rate=100), "")
    assert made.delivery.throttle_s == 0.1
    assert made.remove_request("b")
    assert made.delivery.throttle_s == 1.0
    made.add_request("b", delivery(), "")
    assert not made.remove_request(None)


def test_ids_are_bounded() -> None:
    made, _, _ = subscription()
    for number in range(MAX_REQUESTS - 1):
        made.add_request(number, delivery(), "")
    with pytest.raises(RemoteProtocolError, match="unsubscribe some"):
        made.add_request("more", delivery(), "")
    made.add_request(0, delivery(queue_length=2), "")


@pytest.mark.parametrize(("asked", "kept"), [(0, MAX_QUEUED_MESSAGES), (3, 3), (10**9, MAX_QUEUED_MESSAGES)])
def test_queues_are_as_long_as_asked_within_our_bound(asked: int, kept: int) -> None:
    made, _, _ = subscription(queue_length=asked)
    assert made.queue_length == kept


async def test_without_a_throttle_everything_is_sent() -> None:
    made, outbox, _ = subscription()
    take(made, b"1", b"2", b"3")
    assert sent(outbox) == [b"1", b"2", b"3"]


@on_virtual_time
async def test_a_throttle_without_a_queue_leaves_out_what_comes_too_soon() -> None:
    made, outbox, _ = subscription(throttle_rate=50)
    take(made, b"1", b"2")
    take(made, b"3")
    assert sent(outbox) == [b"1"]
    await asyncio.sleep(0.06)
    take(made, b"4", b"5")
    assert sent(outbox) == [b"4"]


@on_virtual_time
async def test_a_throttle_with_a_queue_hands_on_the_newest_at_its_rate() -> None:
    made, outbox, _ = subscription(throttle_rate=30, queue_length=2)
    begin_s = asyncio.get_running_loop().time()
    take(made, b"1", b"2", b"3", b"4", b"5")
    assert sent(outbox) == [b"1"]
    got: list[bytes] = []
    async with asyncio.timeout(60):
        while len(got) < 2:
            await outbox.wait()
            got += sent(outbox)
    assert got == [b"4", b"5"]
    assert asyncio.get_running_loop().time() - begin_s >= 0.059
    # The client requested this rate: it is not reported as too slow.
    assert made.dropped_count == 0
    await made.close()


@on_virtual_time
async def test_closing_forgets_what_waits() -> None:
    made, outbox, _ = subscription(throttle_rate=1, queue_length=5)
    take(made, b"1", b"2", b"3")
    await made.close()
    await asyncio.sleep(0.01)
    assert sent(outbox) == []


async def test_another_type_is_refused_once() -> None:
    made, outbox, errors = subscription(type="std_msgs/msg/Int32")
    take(made, b"1")
    take(made, b"2")
    assert sent(outbox) == []
    assert errors == ["subscribe: /a: its type is std_msgs/String, not std_msgs/msg/Int32"]


def topics(outbox: Outbox, count: int) -> list[ClientSubscription]:
    return [ClientSubscription(f"/topic_{number}", outbox, print) for number in range(count)]


def put(outbox: Outbox, topic: ClientSubscription, *payloads: bytes, max_messages: int = 1000) -> None:
    whole = Batch(STRING, payloads)
    for index in range(len(payloads)):
        outbox.put(topic, whole, index, max_messages)


def drain(outbox: Outbox) -> list[str | bytes]:
    """Return everything that waits: answers as they are, messages as their payloads."""
    found: list[str | bytes] = []
    while (item := outbox.next()) is not None:
        found.append(item.batch.payloads[item.index] if isinstance(item, Due) else item)
    return found


def test_answers_leave_in_their_order_before_messages_and_topics_in_turn() -> None:
    outbox = Outbox(1_000_000, 1000)
    first, second = topics(outbox, 2)
    image = bytes(TURN_BYTES)
    put(outbox, first, image, b"2")
    outbox.answer("a")
    put(outbox, second, b"1")
    outbox.answer("b")
    assert drain(outbox) == ["a", "b", image, b"1", b"2"]


def test_a_full_topic_loses_its_oldest_and_no_other_topic_does() -> None:
    outbox = Outbox(1000, 1000)
    fast, slow = topics(outbox, 2)
    put(outbox, slow, b"s")
    put(outbox, fast, b"1", b"2", b"3", b"4", max_messages=2)
    put(outbox, slow, b"t")
    assert drain(outbox) == [b"s", b"t", b"3", b"4"]
    assert (fast.dropped_count, slow.dropped_count) == (2, 0)


def test_bytes_are_bounded_and_one_message_is_always_kept() -> None:
    outbox = Outbox(10 * MESSAGE_COST_BYTES, 1000)
    [topic] = topics(outbox, 1)
    put(outbox, topic, *(b"%d" % digit for digit in range(9)))
    put(outbox, topic, b"x" * 5000)
    assert topic.dropped_count == 9
    assert drain(outbox) == [b"x" * 5000]


def test_a_topic_that_is_discarded_leaves_nothing_behind() -> None:
    outbox = Outbox(1000, 1000)
    gone, kept = topics(outbox, 2)
    put(outbox, gone, b"1", b"2")
    put(outbox, kept, b"3")
    outbox.discard(gone)
    assert drain(outbox) == [b"3"]


def test_statuses_beyond_the_bound_are_skipped() -> None:
    outbox = Outbox(1000, 1 << 20)
    for number in range(MAX_STATUSES + 10):
        outbox.answer(str(number), is_status=True)
    outbox.answer("answer")
    found = drain(outbox)
    assert len(found) == MAX_STATUSES + 1
    assert found[-1] == "answer"
    outbox.answer("again", is_status=True)
    assert drain(outbox) == ["again"]


def test_a_client_that_leaves_too_many_answers_overflows() -> None:
    outbox = Outbox(1000, 10)
    outbox.answer("x" * 100)
    assert not outbox.is_overflowing
    outbox.answer("y")
    assert outbox.is_overflowing
    assert drain(outbox) == []


async def test_waiting_ends_with_what_comes_and_where_nothing_more_is_kept() -> None:
    outbox = Outbox(1000, 10)
    [topic] = topics(outbox, 1)
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
