"""Functions of tests that read from boards."""

from __future__ import annotations

from rostether.simulation.simavr.board_events import BoardEvent
from rostether.simulation.simavr.simulated_board import SimulatedBoard


def named(board: SimulatedBoard, name: str) -> list[BoardEvent]:
    """Return the events of a name so far."""
    return [event for event in board.recent if event.name == name]


async def number(board: SimulatedBoard, symbol: str) -> int:
    """Return the value of an unsigned variable of the program."""
    return int.from_bytes(await board.memory(symbol), "little")


async def words16(board: SimulatedBoard, symbol: str) -> list[int]:
    """Return the values of an array of int16_t."""
    data = await board.memory(symbol)
    return [int.from_bytes(data[i : i + 2], "little", signed=True) for i in range(0, len(data), 2)]
