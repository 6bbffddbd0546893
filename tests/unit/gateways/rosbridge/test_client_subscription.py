from __future__ import annotations

import asyncio
from typing import Any, cast

import pytest

from rostether.errors import RemoteProtocolError
from rostether.gateways.rosbridge.client_subscription import (
    MAX_REQUESTS,
    MIN_FRAGMENT_BYTES,
    ClientSubscription,
    Compression,
    Delivery,
    merge,
)
from rostether.gateways.rosbridge.outbox import Due, Outbox
from rostether.gateways.rosbridge.request import Request
from rostether.gateways.rosbridge.settings import MAX_QUEUED_MESSAGES
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection
from rostether.graph.message_stream import LearnedTypes
from unit.bridge.virtual_time import on_virtual_time

STRING = PublisherConnection("/a", {"type": "std_msgs/String"}, cast("LearnedTypes", None))


def delivery(**fields: Any) -> Delivery:
    return Delivery.read(Request({"op": "subscribe", **fields}))


def subscription(**fields: Any) -> tuple[ClientSubscription, Outbox[ClientSubscription], list[str]]:
    errors: list[str] = []
    outbox = Outbox[ClientSubscription](1 << 20, 1 << 20)
    made = ClientSubscription("/a", outbox, errors.append)
    made.add_request(None, delivery(**fields), str(fields.get("type", "")))
    return made, outbox, errors


def take(made: ClientSubscription, *payloads: bytes) -> None:
    made.enqueue(Batch(STRING, payloads))


def sent(outbox: Outbox[ClientSubscription]) -> list[bytes]:
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
