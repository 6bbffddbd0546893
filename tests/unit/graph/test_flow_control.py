"""Back-pressure: when a subscriber pauses a publication, and for how long."""

from __future__ import annotations

import asyncio

import pytest

from rostether.graph.flow_control import (
    DEFAULT_QUEUE_BYTES,
    MIN_READ_BYTES,
    SMALL_STEPS,
    STEPS,
    PublicationFlow,
    Reader,
    SubscriberFlow,
)

LIMIT = DEFAULT_QUEUE_BYTES
HIGH, LOW = 256 << 10, 64 << 10
CHUNK = 64 << 10


class Subscriber:
    """A subscriber whose backlog the test sets."""

    def __init__(
        self, publication: PublicationFlow, limit_bytes: int = LIMIT, reader: Reader | None = None
    ) -> None:
        self.publication = publication
        self.backlog = 0
        self.limit = limit_bytes
        self.lost = 0
        self.flow = SubscriberFlow(publication, lambda: self.backlog, limit_bytes, reader)

    def set(self, backlog: int) -> None:
        self.backlog = backlog
        self.flow.update()

    def publish(self, size: int) -> None:
        self.lost += max(self.backlog + size - self.limit, 0)
        self.set(min(self.backlog + size, self.limit))

    def take(self, size: int) -> None:
        if size:
            self.backlog = max(self.backlog - size, 0)
            self.flow.note_sent()

    def flood(self, rounds: int, taken: int) -> int:
        """Publish a chunk whenever that is allowed; `taken` leaves in each pause. Return the pauses made."""
        pauses = 0
        for _ in range(rounds):
            self.publish(CHUNK)
            while not self.publication.is_open:
                pauses += 1
                self.take(taken)
                self.flow.end_pause()
        return pauses


@pytest.mark.parametrize(
    ("backlogs", "is_open"),
    [
        ([0], True),
        ([HIGH], True),
        ([HIGH + 1], False),
        ([HIGH + 1, LOW + 1], False),
        ([HIGH + 1, LOW], True),
        ([HIGH + 1, LOW, HIGH], True),
        ([HIGH + 1, LOW, HIGH + 1], False),
    ],
)
def test_marks_have_a_distance(backlogs: list[int], is_open: bool) -> None:
    subscriber = Subscriber(PublicationFlow())
    for backlog in backlogs:
        subscriber.set(backlog)
    assert subscriber.publication.is_open is is_open


@pytest.mark.parametrize("taken", [MIN_READ_BYTES, 3 * MIN_READ_BYTES, 10 * MIN_READ_BYTES])
def test_a_slow_subscriber_loses_nothing(taken: int) -> None:
    subscriber = Subscriber(PublicationFlow())
    subscriber.flood(2000, taken)
    assert subscriber.lost == 0


def test_a_subscriber_that_hangs_pauses_the_publisher_a_few_times_and_loses_its_oldest_messages() -> None:
    subscriber = Subscriber(PublicationFlow())
    assert STEPS <= subscriber.flood(2000, 0) <= STEPS + 1
    assert subscriber.flow.hangs
    assert subscriber.lost > 0


def test_one_message_larger_than_the_queue_pauses_no_longer() -> None:
    subscriber = Subscriber(PublicationFlow(), limit_bytes=1000)
    subscriber.set(10 * LIMIT)
    pauses = 0
    while not subscriber.publication.is_open:
        pauses += 1
        subscriber.flow.end_pause()
    assert pauses <= STEPS + 2


@pytest.mark.parametrize("taken", [MIN_READ_BYTES, 10 * MIN_READ_BYTES])
def test_a_subscriber_that_reads_again_pauses_the_publisher_again(taken: int) -> None:
    subscriber = Subscriber(PublicationFlow())
    subscriber.flood(2000, 0)
    lost = subscriber.lost
    # It reads its first bytes during the flood: its backlog is never small again.
    subscriber.take(2 * CHUNK)
    subscriber.flood(2000, taken)
    assert subscriber.lost == lost


def test_a_trickle_pauses_the_publisher_once_for_each_time() -> None:
    subscriber = Subscriber(PublicationFlow())
    subscriber.flood(2000, 0)
    for _ in range(5):
        subscriber.take(MIN_READ_BYTES // 2)
        assert subscriber.flood(100, 0) <= 2


def test_a_node_that_reads_others_first_is_waited_for_longer_but_not_for_ever() -> None:
    reader = Reader()
    starved, served = (
        Subscriber(PublicationFlow(), reader=reader),
        Subscriber(PublicationFlow(), reader=reader),
    )
    pauses = 0
    while not starved.flow.hangs:
        starved.publish(CHUNK)
        while not starved.publication.is_open:
            pauses += 1
            served.publish(CHUNK)
            served.take(CHUNK)
            starved.flow.end_pause()
        assert starved.lost == 0
    assert SMALL_STEPS <= pauses <= SMALL_STEPS + 2


async def test_waiting_ends_after_the_time_of_a_pause() -> None:
    publication = PublicationFlow()
    subscriber = Subscriber(publication)
    subscriber.set(HIGH + CHUNK)
    await publication.drained(0.001)
    assert publication.is_open
    subscriber.set(HIGH + 10 * CHUNK)
    await publication.drained(0.001)
    assert not publication.is_open


async def test_a_pause_counts_only_for_subscribers_that_were_behind_at_its_start() -> None:
    publication = PublicationFlow()
    first, second = Subscriber(publication), Subscriber(publication)
    first.set(HIGH + 1)
    waiting = asyncio.ensure_future(publication.drained(0.01))
    await asyncio.sleep(0)
    second.set(HIGH + 1)
    await waiting
    assert not publication.is_open
    second.flow.end_pause()
    assert publication.is_open


@pytest.mark.parametrize("ending", ["drains", "ends"])
async def test_waiting_ends_when_no_subscriber_is_behind(ending: str) -> None:
    publication = PublicationFlow()
    subscribers = [Subscriber(publication) for _ in range(3)]
    await publication.drained(60.0)
    for subscriber in subscribers:
        subscriber.set(HIGH + 1)
    waiting = asyncio.ensure_future(publication.drained(60.0))
    for subscriber in subscribers:
        await asyncio.sleep(0)
        assert not waiting.done()
        subscriber.set(0) if ending == "drains" else subscriber.flow.end()
    await asyncio.wait_for(waiting, 60)
