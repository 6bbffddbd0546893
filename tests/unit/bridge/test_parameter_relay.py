from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import cast

import pytest

from rostether.bridge.parameter_relay import MAX_WAITING, ParameterRelay, to_answer
from rostether.bridge.settings import BridgeSettings
from rostether.errors import LocalProtocolError, MasterUnreachableError
from rostether.graph.ports import Graph, ParamValue
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import ParameterResponse
from unit.bridge.nodes import World
from waiting import until


class Answers:
    """Replaces the link: keeps the answers that the board would get."""

    def __init__(self) -> None:
        self.given: list[ParameterResponse] = []
        self.sent = 0
        self.limit = 100
        self.takes_nothing = False

    def answer_parameter(
        self, ints: Sequence[int] = (), floats: Sequence[float] = (), strings: Sequence[str] = ()
    ) -> None:
        if self.takes_nothing:
            raise LocalProtocolError("the answer needs 12 bytes, but the device's buffer has 11")
        if len(ints) > self.limit:
            raise LocalProtocolError("412 bytes do not fit in the board's buffer of 280")
        self.given.append(ParameterResponse(tuple(ints), tuple(floats), tuple(strings)))

    def send(self) -> None:
        self.sent += 1


class BrokenGraph:
    """A graph whose master does not answer the first calls."""

    def __init__(self, failures: int, value: ParamValue = 7) -> None:
        self.failures = failures
        self.value = value

    async def get_param(self, name: str) -> ParamValue:
        if self.failures:
            self.failures -= 1
            raise MasterUnreachableError("no master answers")
        return self.value


def relay(world: World, answers: Answers, graph: object = None, timeout_s: float = 0.8) -> ParameterRelay:
    return ParameterRelay(
        cast(HostLink, answers),
        cast(Graph, graph) if graph is not None else world.board,
        world.notices,
        BridgeSettings(parameter_timeout_s=timeout_s),
        answers.send,
    )


@pytest.fixture
async def world() -> World:
    return await World().open()


@pytest.mark.parametrize(
    ("value", "answer"),
    [
        (42, ParameterResponse(ints=(42,))),
        (-(2**31), ParameterResponse(ints=(-(2**31),))),
        (True, ParameterResponse(ints=(1,))),
        ([True, False], ParameterResponse(ints=(1, 0))),
        (2.5, ParameterResponse(floats=(2.5,))),
        (float("inf"), ParameterResponse(floats=(float("inf"),))),
        ([1, 2.5], ParameterResponse(floats=(1.0, 2.5))),
        ("left arm", ParameterResponse(strings=("left arm",))),
        ("", ParameterResponse(strings=("",))),
        (["a", "b"], ParameterResponse(strings=("a", "b"))),
        ([1, 2, 3], ParameterResponse(ints=(1, 2, 3))),
        ([], ParameterResponse()),
        (2**31, None),
        (1e300, None),
        ({"p": 1.0}, None),
        ([1, "a"], None),
        ([True, 2.5], None),
        ([[1], [2]], None),
        (b"binary", None),
    ],
)
def test_values_sent_to_a_board(value: ParamValue, answer: ParameterResponse | None) -> None:
    assert to_answer(value) == answer


async def test_questions_are_answered_in_their_order(world: World) -> None:
    for number in range(5):
        await world.peer.set_param(f"/p{number}", number)
    answers = Answers()
    asking = relay(world, answers)
    for number in range(5):
        asking.ask(f"p{number}")
    await until(lambda: len(answers.given) == 5, "five answers")
    assert answers.given == [ParameterResponse(ints=(number,)) for number in range(5)]
    assert answers.sent == 5


async def test_a_private_name_is_the_boards_own(world: World) -> None:
    await world.peer.set_param("/board/gain", 2.5)
    answers = Answers()
    relay(world, answers).ask("~gain")
    await until(lambda: answers.given, "the answer")
    assert answers.given == [ParameterResponse(floats=(2.5,))]


@pytest.mark.parametrize("name", ["missing", "no spaces", "tree", ""])
async def test_missing_parameters_are_answered_empty_with_one_line(world: World, name: str) -> None:
    await world.peer.set_param("/tree", {"a": 1})
    answers = Answers()
    asking = relay(world, answers)
    for _ in range(3):
        asking.ask(name)
    await until(lambda: len(answers.given) == 3, "the answers")
    assert answers.given == [ParameterResponse()] * 3
    assert len(world.reporter.texts) == 1


@pytest.mark.parametrize(
    ("value", "reason"),
    [({"a": 1}, "this is a mapping"), ([1, "a"], "other or mixed types"), (2**31, "outside these ranges")],
)
async def test_the_reason_names_what_a_board_cannot_read(
    world: World, value: ParamValue, reason: str
) -> None:
    answers = Answers()
    relay(world, answers, BrokenGraph(0, value)).ask("gain")
    await until(lambda: answers.given, "the answer")
    [text] = world.reporter.texts
    assert reason in text


async def test_a_master_that_was_away_for_a_moment_is_asked_again(world: World) -> None:
    answers = Answers()
    relay(world, answers, BrokenGraph(2)).ask("gain")
    await until(lambda: answers.given, "the answer")
    assert answers.given == [ParameterResponse(ints=(7,))]
    assert world.reporter.texts == []


async def test_a_missing_master_delays_an_answer_less_than_the_board_waits(world: World) -> None:
    answers = Answers()
    relay(world, answers, BrokenGraph(1000), timeout_s=0.15).ask("gain")
    await until(lambda: answers.given, "the answer")
    assert answers.given == [ParameterResponse()]
    assert "no master answers" in world.reporter.texts[0]


async def test_an_answer_too_large_for_the_board_is_replaced(world: World) -> None:
    await world.peer.set_param("/list", list(range(101)))
    answers = Answers()
    relay(world, answers).ask("list")
    await until(lambda: answers.given, "the answer")
    assert answers.given == [ParameterResponse()]
    assert "buffer of 280" in world.reporter.texts[0]


async def test_a_board_that_accepts_no_answer_is_reported_and_later_requests_are_answered(
    world: World,
) -> None:
    await world.peer.set_param("/gain", 2)
    answers = Answers()
    answers.takes_nothing = True
    asking = relay(world, answers)
    asking.ask("gain")
    await until(lambda: world.reporter.texts, "the line")
    assert world.reporter.texts == [
        "parameter gain, requested by the board: the answer needs 12 bytes, but the device's buffer has "
        "11; even an empty answer does not fit; enlarge the input buffer of the sketch's NodeHandle_"
    ]
    answers.takes_nothing = False
    asking.ask("gain")
    await until(lambda: answers.given, "the answer")
    assert answers.given == [ParameterResponse(ints=(2,))]


async def test_a_defect_loses_one_answer_and_is_one_line(world: World) -> None:
    class Defective(BrokenGraph):
        async def get_param(self, name: str) -> ParamValue:
            if name == "odd":
                raise KeyError(name)
            return self.value

    answers = Answers()
    asking = relay(world, answers, Defective(0))
    asking.ask("odd")
    asking.ask("gain")
    await until(lambda: len(answers.given) == 2, "the answers")
    assert answers.given == [ParameterResponse(), ParameterResponse(ints=(7,))]
    assert world.reporter.texts == [
        "parameter odd, requested by the board: KeyError: 'odd'; please report it"
    ]


async def test_a_flood_of_questions_is_bounded(world: World) -> None:
    answers = Answers()
    asking = relay(world, answers)
    for _ in range(1000):
        asking.ask("missing")
    await until(lambda: len(answers.given) == MAX_WAITING, "the answers")
    await asyncio.sleep(0)
    assert len(answers.given) == MAX_WAITING


async def test_a_lost_board_gets_nothing(world: World) -> None:
    answers = Answers()
    asking = relay(world, answers, BrokenGraph(1000))
    asking.ask("gain")
    await asyncio.sleep(0)
    asking.close()
    asking.close()
    await asyncio.sleep(0)
    assert answers.given == []
