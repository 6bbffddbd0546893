"""Commands to a simulated OpenCR and its robot as lines of text, and the board as its node uses it."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator, Callable

from rostether.errors import BoardError, ConfigError
from rostether.simulation.opencr.board import BLUETOOTH, OpenCrBoard
from rostether.simulation.opencr.drive_base import LEFT_ID, RIGHT_ID
from rostether.simulation.opencr.pins import pin_name, pin_number
from rostether.simulation.simavr.board_events import BoardEvent

_BUTTONS = {"none": 0, "up": 1, "down": 2, "left": 4, "right": 8}
_SERVOS = {"left": LEFT_ID, "right": RIGHT_ID}
_INPUTS = ("PUSH_SW_1", "PUSH_SW_2", "DIP_SW_1", "DIP_SW_2", *(f"A{number}" for number in range(6)))
# The levels at rest. The user LEDs are on while their pins are low.
_OUTPUTS = {
    **{f"LED_USER_{number}": True for number in range(1, 5)},
    "LED_STATUS": False,
    "DXL_PWR_EN": False,
}
# The range of an HC-SR04.
_MAX_RANGE_M = 4.0


def execute(board: OpenCrBoard, line: str) -> BoardEvent | None:
    """Execute a line; return the answer, if it has one. Raises ConfigError for an invalid line."""
    word, _, rest = line.strip().partition(" ")
    action = _ACTIONS.get(word)
    if action is None:
        known = " ".join(sorted(_ACTIONS))
        raise ConfigError(f"{word}: the simulated OpenCR has no such command; its commands are {known}")
    return action(board, rest.split())


def _pin(board: OpenCrBoard, arguments: list[str]) -> BoardEvent | None:
    answer = None
    for argument in _checked(arguments, "pin BDPIN_PUSH_SW_1=1"):
        name, separator, level = argument.partition("=")
        number = pin_number(name)
        if not separator:
            level_now = int(board.pins.get(number, False))
            answer = board.event("pin", pin=pin_name(number), level=level_now)
        elif level in ("0", "1"):
            board.set_pin(name, high=level == "1")
        else:
            raise ConfigError(f"{argument}: write 0 or 1 after the pin, such as pin {name}=1")
    return answer


def _adc(board: OpenCrBoard, arguments: list[str]) -> None:
    for argument in _checked(arguments, "adc A1=1.5"):
        name, _, volts = argument.partition("=")
        board.set_voltage(name, _number(volts, f"adc {name}=1.5"))


def _battery(board: OpenCrBoard, arguments: list[str]) -> None:
    (volts,) = _checked(arguments, "battery 11.1", count=1)
    board.set_battery(_number(volts, "battery 11.1"))


def _range(board: OpenCrBoard, arguments: list[str]) -> None:
    (meters,) = _checked(arguments, "range 0.5", count=1)
    value = None if meters == "none" else _number(meters, "range 0.5")
    if value is not None and not 0.02 <= value <= _MAX_RANGE_M:
        raise ConfigError(
            f"range {meters}: the sonar measures 0.02 to {_MAX_RANGE_M:g} m; range none means no obstacle"
        )
    board.set_range(value)


def _remote(board: OpenCrBoard, arguments: list[str]) -> None:
    buttons = 0
    for name in _checked(arguments, "remote up left"):
        if name not in _BUTTONS:
            raise ConfigError(f"remote {name}: the remote control has the buttons {', '.join(_BUTTONS)}")
        buttons |= _BUTTONS[name]
    board.send_remote_buttons(buttons)


def _overload(board: OpenCrBoard, arguments: list[str]) -> None:
    """Overload a servo, so that it switches its torque off."""
    (name,) = _checked(arguments, "overload left", count=1)
    if name not in _SERVOS:
        raise ConfigError(f"overload {name}: the servos are left and right")
    board.base.servos[_SERVOS[name]].fail(0x20)


def _pose(board: OpenCrBoard, _arguments: list[str]) -> BoardEvent:
    base = board.base
    base.advance()
    return board.event(
        "pose",
        x_m=round(base.x_m, 4),
        y_m=round(base.y_m, 4),
        heading_rad=round(base.heading_rad, 4),
        speed_m_s=round(base.speed_m_s, 4),
        turn_rad_s=round(base.turn_rate_rad_s, 4),
    )


def _watch(board: OpenCrBoard, arguments: list[str]) -> None:
    board.watched |= {
        name if name == BLUETOOTH else pin_number(name)
        for name in _checked(arguments, f"watch BDPIN_LED_USER_1 {BLUETOOTH}")
    }


_ACTIONS: dict[str, Callable[[OpenCrBoard, list[str]], BoardEvent | None]] = {
    "adc": _adc,
    "battery": _battery,
    "overload": _overload,
    "pin": _pin,
    "pose": _pose,
    "range": _range,
    "remote": _remote,
    "watch": _watch,
}


def _checked(arguments: list[str], example: str, *, count: int | None = None) -> list[str]:
    if not arguments or (count is not None and len(arguments) != count):
        raise ConfigError(f"write {'one value' if count == 1 else 'values'}, such as {example}")
    return arguments


def _number(text: str, example: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"{text!r} is not a number; write for example {example}") from None


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
            execute(self._board, re.sub(r"=z\b", "=0", line))
        except ConfigError as error:
            raise BoardError(str(error)) from error

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
