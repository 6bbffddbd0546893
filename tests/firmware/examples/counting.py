"""Cycles of the client library on a simulated Mega, compared with the established library."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from pathlib import Path

from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions
from rostether.rosserial.frame import encode_frame
from rostether.simulation.simavr.simulated_board import SimulatedBoard

SKETCH = Path(__file__).parents[3] / "benchmarks" / "firmware" / "cycles"
TIMEOUT_S = 60.0


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation whose cycles are counted, with the cycles of the established library, if known, and the
    largest allowed part of them.

    `max_cycles` is the limit of the test with a line in memory, a few percent above the last measurement.
    """

    name: str
    established: int | None
    max_part: float
    max_cycles: int


OPERATIONS = (
    Operation("first spinOnce", None, 1, 590),
    # The established library's cycles are those of a similar sketch.
    Operation("answer with 7 topics", 24852, 1, 15800),
    Operation("publish String, 12 letters", 1023, 1, 910),
    Operation("publish Range", 1444, 1, 1444),
    Operation("publish Imu", 26431, 1 / 3, 5950),
    Operation("publish Odometry", 60277, 1 / 3, 13000),
    Operation("idle spinOnce", 309, 1 / 2, 120),
    Operation("receive and dispatch Int16", 1909, 1, 1660),
    Operation("receive and dispatch Empty", 1660, 1, 1390),
    Operation("receive and dispatch String, 12 letters", 4042, 1, 2400),
)
# The topics to which the sketch subscribes have the ids 100 to 102.
INPUTS = {
    OPERATIONS[1]: encode_frame(0, b""),
    OPERATIONS[7]: encode_frame(100, b"\x34\x12"),
    OPERATIONS[8]: encode_frame(102, b""),
    OPERATIONS[9]: encode_frame(101, b"\x0c\0\0\0hello world!"),
}


def count(*, neutral: bool) -> dict[Operation, int]:
    """Return the cycles of each operation, on a line in memory or on Serial at 1 Mbaud."""
    return asyncio.run(count_async(neutral=neutral))


async def count_async(*, neutral: bool) -> dict[Operation, int]:
    """Return the same as `count`."""
    options = BuildOptions(defines=("NEUTRAL_HARDWARE",) if neutral else ())
    built = await build_sketch(SKETCH, find_board("mega"), options)
    cycles: dict[Operation, int] = {}
    async with await SimulatedBoard.start(built.elf, board="mega", realtime=False, paused=True) as board:
        events = board.events()
        event = asyncio.ensure_future(anext(events))
        await asyncio.sleep(0)
        await board.send_command("run")
        async with asyncio.timeout(TIMEOUT_S):
            for operation in OPERATIONS:
                if not neutral and operation in INPUTS:
                    await board.send(INPUTS[operation])
                while (await event).name != "region":
                    event = asyncio.ensure_future(anext(events))
                cycles[operation] = int(event.result()["cycles"])
                event = asyncio.ensure_future(anext(events))
        event.cancel()
    return cycles
