"""Commands to a simulated OpenCR and its robot, as lines of text."""

from __future__ import annotations

from collections.abc import Callable

from rostether.errors import ConfigError
from rostether.simulation.opencr.board import BLUETOOTH, OpenCrBoard
from rostether.simulation.opencr.drive_base import LEFT_ID, RIGHT_ID
from rostether.simulation.opencr.pins import pin_name, pin_number
from rostether.simulation.simavr.board_events import BoardEvent

_BUTTONS = {"none": 0, "up": 1, "down": 2, "left": 4, "right": 8}
_SERVOS = {"left": LEFT_ID, "right": RIGHT_ID}
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
