"""A board survives any commands, and executes the next valid one."""

from __future__ import annotations

from random import Random

import pytest

from rostether.errors import BoardError
from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build

pytestmark = pytest.mark.simavr

WORDS = [
    "adc",
    "aref",
    "attitude",
    "autoreset",
    "cycles",
    "fault",
    "guard",
    "hcsr04",
    "memory",
    "network",
    "pause",
    "pin",
    "power",
    "range",
    "reset",
    "send",
    "servo",
    "stack",
    "unwatch",
    "watch",
]
VALUES = [
    "D0",
    "D13",
    "A0",
    "13",
    "serial",
    "on",
    "off",
    "none",
    "0",
    "-1",
    "1e308",
    "nan",
    "=",
    ",",
    ":",
    "A0=2.5",
    "D7=1",
    "D7=z",
    "trig=D6,echo=D5",
    "flip=0.1,drop=0.1,seed=3",
    "to:flip=1",
    "0x100..0x200",
    "0xffff",
    "starts",
    "fence",
    "20ms",
    "48656c6c6f",
    "zz",
    "localhost:1",
    "in",
    "10",
    "20",
    "\x00",
    "ÿ",
    "é",
    "#5",
]


@pytest.mark.parametrize("seed", range(4))
async def test_commands_in_any_order(start: Start, seed: int) -> None:
    rng = Random(seed)
    kind = rng.choice(("uno", "mega", "leonardo"))
    board = await start(build("wrong", board=kind), board=kind)
    understood = 0
    for _ in range(150):
        line = " ".join([rng.choice(WORDS), *rng.choices(VALUES, k=rng.randrange(4))])
        try:
            await board.send_command(line)
            understood += 1
        except BoardError as error:
            assert "\n" not in str(error)
            assert not board.has_ended
    assert 10 < understood < 150
    await board.run("2ms")
    assert await board.cycles() >= 32_000
