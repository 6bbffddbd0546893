from __future__ import annotations

import asyncio
from typing import Any

import pytest

from rostether.bridge.endpoint.openings import CHANGED_AT_ONCE, EndpointOpenings
from rostether.errors import GraphError, TypeMismatchError
from rostether.rosserial.events import TopicRole
from unit.bridge.nodes import World, topic_info
from waiting import until

SLOT = (TopicRole.PUBLISHER, "level")


class Endpoint:
    """Records its calls in a list that it shares with others."""

    def __init__(self, name: str, done: list[str]) -> None:
        self.info = topic_info(name)
        self.name = name
        self.done = done
        self.errors: list[Exception] = []
        self.may_close = asyncio.Event()
        self.may_close.set()

    async def open(self) -> None:
        if self.errors:
            raise self.errors.pop(0)
        self.done.append(f"{self.name} in")

    async def close(self) -> None:
        await self.may_close.wait()
        self.done.append(f"{self.name} out")
        if self.errors:
            raise self.errors.pop(0)


@pytest.fixture
async def world() -> World:
    return await World().open()


async def test_the_old_endpoint_closes_before_the_new_one_opens(world: World) -> None:
    done: list[str] = []
    openings = EndpointOpenings(world.notices)
    old: Any = Endpoint("old", done)
    new: Any = Endpoint("new", done)
    old.may_close.clear()
    openings.open(SLOT, old)
    await until(lambda: done == ["old in"], "the old")
    openings.close(SLOT, old)
    openings.open(SLOT, new)
    await asyncio.sleep(0.01)
    assert done == ["old in"]
    old.may_close.set()
    await until(lambda: done == ["old in", "old out", "new in"], "the new")


async def test_an_endpoint_closed_before_it_opened_waits_for_nothing(world: World) -> None:
    done: list[str] = []
    openings = EndpointOpenings(world.notices)
    endpoints: list[Any] = [Endpoint(str(number), done) for number in range(3)]
    for endpoint in endpoints:
        openings.open(SLOT, endpoint)
        openings.close(SLOT, endpoint)
    await asyncio.wait_for(openings.finish(), 60.0)
    assert done == ["0 out", "1 out", "2 out"]


async def test_an_endpoint_refused_for_its_type_opens_when_another_has_left(world: World) -> None:
    done: list[str] = []
    openings = EndpointOpenings(world.notices)
    holder: Any = Endpoint("/level", done)
    refused: Any = Endpoint("level", done)
    refused.errors = [TypeMismatchError("published as another type")]
    openings.open((TopicRole.PUBLISHER, "/level"), holder)
    openings.open(SLOT, refused)
    await until(lambda: world.reporter.having("level is not bridged"), "the refusal")
    openings.close((TopicRole.PUBLISHER, "/level"), holder)
    await until(lambda: done == ["/level in", "/level out", "level in"], "the second try")
    await until(lambda: world.reporter.texts[-1] == "level is bridged now", "the line")


async def test_a_refusal_at_the_end_is_a_line(world: World) -> None:
    openings = EndpointOpenings(world.notices)
    endpoint: Any = Endpoint("level", [])
    openings.open(SLOT, endpoint)
    await until(lambda: endpoint.done, "the opening")
    endpoint.errors = [GraphError("the master is away")]
    openings.close(SLOT, endpoint)
    await until(lambda: world.reporter.texts, "the line")
    assert world.reporter.texts == ["level may still be listed: the master is away"]


async def test_a_defect_of_one_endpoint_is_a_line_and_the_next_opens(world: World) -> None:
    done: list[str] = []
    openings = EndpointOpenings(world.notices)
    defective: Any = Endpoint("level", done)
    defective.errors = [KeyError("open"), KeyError("close")]
    openings.open(SLOT, defective)
    await until(lambda: world.reporter.texts, "the line")
    openings.close(SLOT, defective)
    following: Any = Endpoint("next", done)
    openings.open(SLOT, following)
    await until(lambda: "next in" in done, "the next")
    assert world.reporter.texts == [
        "level is not bridged: KeyError: 'open'; please report it",
        "level may still be listed: KeyError: 'close'; please report it",
    ]


async def test_finishing_has_a_time_limit(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.bridge.endpoint.openings.CLOSE_LIMIT_S", 0.02)
    openings = EndpointOpenings(world.notices)
    hanging: Any = Endpoint("level", [])
    hanging.may_close.clear()
    openings.open(SLOT, hanging)
    openings.close(SLOT, hanging)
    await asyncio.wait_for(openings.finish(), 60.0)


async def test_announcements_at_once_are_opened_turn_by_turn(world: World) -> None:
    done: list[str] = []
    openings = EndpointOpenings(world.notices)
    endpoints: list[Any] = [Endpoint(str(number), done) for number in range(50)]
    for number, endpoint in enumerate(endpoints):
        openings.open((TopicRole.PUBLISHER, str(number)), endpoint)
    max_per_turn, before = 0, 0
    for _ in range(500):
        await asyncio.sleep(0)
        max_per_turn, before = max(max_per_turn, len(done) - before), len(done)
    assert done == [f"{number} in" for number in range(50)]
    assert max_per_turn == 1


async def test_an_endpoint_that_hangs_holds_up_no_other(world: World) -> None:
    done: list[str] = []
    openings = EndpointOpenings(world.notices)
    hanging: Any = Endpoint("hanging", done)
    hanging.may_close.clear()
    openings.open(SLOT, hanging)
    await until(lambda: done == ["hanging in"], "the first")
    openings.close(SLOT, hanging)
    other: Any = Endpoint("other", done)
    openings.open((TopicRole.PUBLISHER, "other"), other)
    await until(lambda: "other in" in done, "the other")
    assert "hanging out" not in done
    hanging.may_close.set()
    await until(lambda: "hanging out" in done, "the end")


@pytest.mark.parametrize("closes", [False, True])
async def test_a_board_s_endpoints_come_and_leave_a_few_at_a_time(world: World, closes: bool) -> None:
    openings = EndpointOpenings(world.notices)
    begun: list[str] = []
    may_go_on = asyncio.Event()

    class Slow(Endpoint):
        async def open(self) -> None:
            begun.append(self.name)
            await may_go_on.wait()
            self.done.append(self.name)

        async def close(self) -> None:
            await Slow.open(self)

    done: list[str] = []
    for number in range(20):
        endpoint: Any = Slow(str(number), done)
        act = openings.close if closes else openings.open
        act((TopicRole.PUBLISHER, endpoint.name), endpoint)
    for _ in range(100):
        await asyncio.sleep(0)
    assert len(begun) == CHANGED_AT_ONCE
    may_go_on.set()
    await until(lambda: len(done) == 20, "all")
