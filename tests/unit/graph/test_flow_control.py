"""Back-pressure: the state table, and waiting."""

from __future__ import annotations

import asyncio

import pytest

from rostether.graph.flow_control import PublicationFlow, SubscriberFlow

HIGH, LOW = 1000, 250


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
async def test_marks_have_a_distance(backlogs: list[int], is_open: bool) -> None:
    publication = PublicationFlow()
    flow = SubscriberFlow(publication, HIGH)
    for backlog in backlogs:
        flow.note_backlog(backlog)
    assert publication.is_open is is_open
    assert not flow.is_slow


async def test_who_is_not_drained_in_time_is_slow_until_its_backlog_is_gone() -> None:
    publication = PublicationFlow()
    flow = SubscriberFlow(publication, HIGH)
    flow.note_backlog(HIGH + 1)
    await publication.drained(0.001)
    assert flow.is_slow
    assert publication.is_open
    for backlog in (HIGH * 50, HIGH, LOW + 1):
        flow.note_backlog(backlog)
        assert flow.is_slow
        assert publication.is_open
    flow.note_backlog(LOW)
    assert not flow.is_slow
    flow.note_backlog(HIGH + 1)
    assert not publication.is_open


@pytest.mark.parametrize(
    ("taken", "is_open"),
    [
        # (seconds since it was given up, bytes it took then)
        ([(0.0, HIGH - 1)], True),
        ([(0.0, HIGH)], False),
        ([(0.0, HIGH // 2), (0.09, HIGH // 2)], False),
        ([(0.0, HIGH // 2), (0.11, HIGH // 2), (0.22, HIGH // 2)], True),
        ([(0.0, HIGH // 2), (0.11, HIGH // 2), (0.2, HIGH // 2)], False),
    ],
)
async def test_who_takes_much_in_the_time_of_a_pause_is_not_slow(
    taken: list[tuple[float, int]], is_open: bool
) -> None:
    publication = PublicationFlow()
    flow = SubscriberFlow(publication, HIGH)
    flow.note_taken(HIGH, 0.0)
    flow.note_backlog(50 * HIGH)
    flow.give_up(0.1)
    assert publication.is_open
    for time_s, taken_bytes in taken:
        flow.note_taken(taken_bytes, 1000.0 + time_s)
        flow.note_backlog(50 * HIGH)
    assert publication.is_open is is_open


async def test_only_who_was_behind_when_the_waiting_began_is_given_up() -> None:
    publication = PublicationFlow()
    first, second = SubscriberFlow(publication, HIGH), SubscriberFlow(publication, HIGH)
    first.note_backlog(HIGH + 1)
    waiting = asyncio.ensure_future(publication.drained(0.01))
    await asyncio.sleep(0)
    second.note_backlog(HIGH + 1)
    await waiting
    assert first.is_slow
    assert not second.is_slow
    assert not publication.is_open


@pytest.mark.parametrize("ending", ["drains", "ends"])
async def test_waiting_ends_when_nobody_is_behind_any_more(ending: str) -> None:
    publication = PublicationFlow()
    flows = [SubscriberFlow(publication, HIGH) for _ in range(3)]
    await publication.drained(60.0)
    for flow in flows:
        flow.note_backlog(HIGH + 1)
    waiting = asyncio.ensure_future(publication.drained(60.0))
    for flow in flows:
        await asyncio.sleep(0)
        assert not waiting.done()
        flow.note_backlog(0) if ending == "drains" else flow.end()
    await asyncio.wait_for(waiting, 60)
    assert not any(flow.is_slow for flow in flows)
