"""A simulated OpenCR for its node: pins by name, and commands whose errors are BoardError."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator

from rostether.errors import BoardError, ConfigError
from rostether.simulation.opencr.board import OpenCrBoard
from rostether.simulation.opencr.commands import execute
from rostether.simulation.opencr.pins import pin_name
from rostether.simulation.simavr.board_events import BoardEvent

_INPUTS = ("PUSH_SW_1", "PUSH_SW_2", "DIP_SW_1", "DIP_SW_2", *(f"A{number}" for number in range(6)))
# The levels at rest. The user LEDs are on while their pins are low.
_OUTPUTS = {
    **{f"LED_USER_{number}": True for number in range(1, 5)},
    "LED_STATUS": False,
    "DXL_PWR_EN": False,
}


class OpenCrNodeBoard:
    """Implements `NodeBoard` for an OpenCR."""

    kind = "opencr"
    mcu = "stm32f746"
    commands = frozenset(("adc", "battery", "overload", "pin", "range", "remote"))

    def __init__(self, board: OpenCrBoard) -> None:
        self._board = board

    @property
    def has_ended(self) -> bool:
        """Whether the program has ended."""
        return self._board.has_ended

    async def pins(self) -> dict[str, str]:
        """Return the state of each pin by name, such as `in0` and `out1`."""
        inputs = dict.fromkeys(_INPUTS, False) | _by_short_name(self._board.inputs)
        outputs = _OUTPUTS | _by_short_name(self._board.pins)
        shown = {name: f"in{high:d}" for name, high in inputs.items() if name not in outputs}
        return shown | {name: f"out{high:d}" for name, high in outputs.items()}

    async def send_command(self, line: str) -> None:
        """Execute a command; `pin NAME=z` releases a button. Raises BoardError."""
        try:
            # A button that is not pressed has the level 0.
            answer = execute(self._board, re.sub(r"=z\b", "=0", line))
        except ConfigError as error:
            raise BoardError(str(error)) from error
        if answer is not None:
            raise BoardError(f"{line}: write the level after each pin, such as pin BDPIN_PUSH_SW_1=1")

    async def ask(self, line: str, answer: str) -> BoardEvent:
        """Return the robot's pose, like the answer of an AVR board to `wheels`. Raises BoardError."""
        if (line, answer) != ("wheels", "wheels"):
            raise BoardError(f"the simulated OpenCR does not answer {line!r}")
        event = execute(self._board, "pose")
        assert event is not None
        return event

    async def events(self) -> AsyncIterator[BoardEvent]:
        """Yield no events; end when the program has ended."""
        await self._board.wait_end()
        nothing: tuple[BoardEvent, ...] = ()
        for event in nothing:
            yield event


def _by_short_name(levels: dict[int, bool]) -> dict[str, bool]:
    return {pin_name(number).removeprefix("BDPIN_"): high for number, high in levels.items()}
