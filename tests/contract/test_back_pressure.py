"""Slow subscribers: they delay a publisher for a limited time, then lose their oldest messages."""

from __future__ import annotations

import asyncio

import pytest

from contract.capabilities import Capabilities
from contract.graphs import STRING, Inbox, string
from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES, STEPS
from rostether.graph.ports import JoinGraph, Publisher
from waiting import until

pytestmark = pytest.mark.slow

PAYLOAD_BYTES = 16 << 10
# More than the sockets between two nodes and the publisher's queue can hold on any system.
MAX_QUEUED = 4096


def payload(number: int) -> bytes:
    return string(f"{number:08}".ljust(PAYLOAD_BYTES - 4, "."))


def numbers(inbox: Inbox) -> list[int]:
    return [int(each[4:12]) for each in inbox.payloads]


async def publish_until_behind(publisher: Publisher, reader: Inbox, first: int = 0) -> int:
    """Publish one by one until a subscriber is behind; return the next number."""
    for number in range(first, first + MAX_QUEUED):
        if not publisher.publish_raw([payload(number)]):
            return number + 1
        # The other subscriber reads in the meantime.
        await until(lambda: len(reader.payloads) > number)  # noqa: B023 - awaited at once
    raise AssertionError("the publisher never noticed that a subscriber is behind")


async def test_a_slow_subscriber_that_reads_again_loses_nothing(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    capabilities.require("detects_slow_subscribers")
    talker, listener = await join("/talker"), await join("/listener")
    slow, quick = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, slow.store)
    await listener.subscribe("/chat", STRING, quick.store)
    await until(lambda: publisher.subscriber_count == 2 and subscriber.publisher_count == 1)
    subscriber.pause()
    sent = await publish_until_behind(publisher, quick)
    subscriber.resume()
    await publisher.drained(60.0)
    assert publisher.publish_raw([payload(sent)])
    await until(lambda: len(slow.payloads) == len(quick.payloads) == sent + 1)
    assert numbers(slow) == numbers(quick) == list(range(sent + 1))
    assert publisher.dropped_count == 0


async def test_a_subscriber_that_hangs_does_not_delay_others_and_loses_its_oldest_messages(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    capabilities.require("detects_slow_subscribers")
    talker, listener = await join("/talker"), await join("/listener")
    slow, quick = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING, queue_bytes=20 * PAYLOAD_BYTES)
    subscriber = await listener.subscribe("/chat", STRING, slow.store)
    await listener.subscribe("/chat", STRING, quick.store)
    await until(lambda: publisher.subscriber_count == 2 and subscriber.publisher_count == 1)
    subscriber.pause()
    sent = await publish_until_behind(publisher, quick)
    # The subscriber reads nothing, so the pauses of the publisher end.
    pauses = 0
    for _ in range(100):
        while not publisher.publish_raw([]):
            pauses += 1
            await publisher.drained(0.01)
        publisher.publish_raw([payload(sent)])
        sent += 1
        await until(lambda: len(quick.payloads) == sent)  # noqa: B023 - awaited at once
    assert pauses <= 2 * STEPS
    assert publisher.publish_raw([])
    assert numbers(quick) == list(range(sent))
    assert publisher.dropped_count > 0
    # When it reads again, it receives complete messages in order up to the newest one.
    subscriber.resume()
    await until(lambda: len(slow.payloads) == sent - publisher.dropped_count)
    received = numbers(slow)
    assert received == sorted(set(received))
    assert received[-19:] == list(range(sent - 19, sent))
    subscriber.pause()
    await publish_until_behind(publisher, quick, sent)


async def test_the_newest_message_is_kept_even_if_it_is_larger_than_the_queue(
    join: JoinGraph, capabilities: Capabilities
) -> None:
    capabilities.require("detects_slow_subscribers")
    talker, listener = await join("/talker"), await join("/listener")
    slow, quick = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING, queue_bytes=1000)
    subscriber = await listener.subscribe("/chat", STRING, slow.store)
    await listener.subscribe("/chat", STRING, quick.store)
    await until(lambda: publisher.subscriber_count == 2 and subscriber.publisher_count == 1)
    subscriber.pause()
    sent = await publish_until_behind(publisher, quick)
    publisher.publish_raw([payload(sent), payload(sent + 1)])
    subscriber.resume()
    await until(lambda: slow.payloads and numbers(slow)[-1] == sent + 1)


async def test_waiting_ends_when_the_subscriber_leaves(join: JoinGraph, capabilities: Capabilities) -> None:
    capabilities.require("detects_slow_subscribers")
    talker, listener = await join("/talker"), await join("/listener")
    slow, quick = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, slow.store)
    await listener.subscribe("/chat", STRING, quick.store)
    await until(lambda: publisher.subscriber_count == 2 and subscriber.publisher_count == 1)
    await publisher.drained(10.0)
    subscriber.pause()
    await publish_until_behind(publisher, quick)
    waiting = asyncio.ensure_future(publisher.drained(60.0))
    await subscriber.close()
    await asyncio.wait_for(waiting, 60)
    assert publisher.publish_raw([payload(0)])


async def test_a_subscriber_that_hangs_gets_the_newest_messages(join: JoinGraph) -> None:
    talker, listener = await join("/talker"), await join("/listener")
    slow, quick = Inbox(), Inbox()
    publisher = await talker.advertise("/chat", STRING, queue_bytes=20 * PAYLOAD_BYTES)
    subscriber = await listener.subscribe("/chat", STRING, slow.store)
    await listener.subscribe("/chat", STRING, quick.store)
    await until(lambda: publisher.subscriber_count == 2 and subscriber.publisher_count == 1)
    subscriber.pause()
    # Many times what the queues hold, at the speed of the subscriber.
    sent = 3 * DEFAULT_QUEUE_BYTES // PAYLOAD_BYTES
    for number in range(sent):
        if not publisher.publish_raw([payload(number)]):
            await publisher.drained(0.01)
        await until(lambda: len(quick.payloads) > number)  # noqa: B023 - awaited at once
    subscriber.resume()
    await until(lambda: slow.payloads and numbers(slow)[-1] == sent - 1)
    received = numbers(slow)
    assert received == sorted(set(received))
    assert numbers(quick) == list(range(sent))
