from __future__ import annotations

import pytest

from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build
from unit.simulation.simavr.readings import named, number

pytestmark = pytest.mark.simavr

POWER_ON_FLAG = 0x01
EXTERNAL_FLAG = 0x02


async def test_noise_in_ram_comes_from_the_seed(start: Start) -> None:
    first, again, other = [
        await (await start(build("wrong"), seed=seed)).memory("0x300", 64) for seed in (1, 1, 2)
    ]
    assert first == again != other
    assert len(set(first)) > 30


async def test_a_reset_keeps_ram_and_restarts(start: Start) -> None:
    board = await start(build("wrong"))
    await board.run("1ms")
    assert await number(board, "cause") == POWER_ON_FLAG
    first, noise = await number(board, "starts"), await board.memory("0x300", 64)
    await board.reset()
    await board.run("1ms")
    assert await number(board, "cause") == EXTERNAL_FLAG
    assert (await number(board, "starts") - first) & 0xFF == 1
    assert await board.memory("0x300", 64) == noise
    assert [event["cause"] for event in named(board, "reset")] == ["power", "external"]


async def test_power_that_returns_brings_other_noise(start: Start) -> None:
    board = await start(build("echo"), "watch serial")
    await board.run("1ms")
    noise = await board.memory("0x300", 64)
    await board.power(False)
    await board.send(b"lost")
    await board.run("5ms")
    await board.reset()
    assert board.serial == b""
    await board.power(True)
    assert await board.memory("0x300", 64) != noise
    await board.run("1ms")
    await board.send(b"here")
    await board.run("5ms")
    assert board.serial == b"here"
    assert [event["cause"] for event in named(board, "reset")] == ["power", "power"]


async def test_it_can_be_requested_twice(start: Start) -> None:
    board = await start(build("echo"))
    for on in (True, False, False, True, True):
        await board.power(on)
    assert len(named(board, "reset")) == 2
    assert len(named(board, "power")) == 1


async def test_the_same_commands_give_the_same_events(start: Start) -> None:
    async def life() -> list[tuple[str, float, str]]:
        board = await start(build("check", "INTERRUPTS"), "watch serial", "fault flip=0.1,seed=5", seed=7)
        await board.run("3ms")
        await board.send(bytes(range(100)))
        await board.run("20ms")
        await board.reset()
        await board.run("7ms")
        return [(event.name, event.time_s, str(dict(event.values))) for event in board.recent]

    assert await life() == await life()
