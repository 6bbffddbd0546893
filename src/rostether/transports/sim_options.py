"""Translates the options in the link address of a simulated board to commands of that board.

In an address `=` and `&` separate options, so a `=` within a value is written `:`, and a space as a comma.
`adc=A0:2.5,A1:1` is the command `adc A0=2.5 A1=1`, and `fault=to:flip:0.01,seed:3` is the command
`fault to:flip=0.01,seed=3`.
"""

from __future__ import annotations

from collections.abc import Mapping

COMMAND_OPTIONS = (
    "adc",
    "aref",
    "attitude",
    "autoreset",
    "battery",
    "fault",
    "hcsr04",
    "network",
    "pin",
    "range",
    "servo",
    "w5100",
    "watch",
    "wheels",
)
# Commands whose values are separated by spaces; those of the others are separated by commas.
_SPACE_SEPARATED = ("adc", "attitude", "pin", "servo", "watch")
# Commands whose values are settings such as A0=2.5.
_WITH_SETTINGS = ("adc", "fault", "hcsr04", "pin", "w5100", "wheels")


def sim_commands(options: Mapping[str, str]) -> tuple[str, ...]:
    """Return the commands for the board from an address's options, in the same order."""
    return tuple(_line(key, value) for key, value in options.items() if key in COMMAND_OPTIONS)


def _line(key: str, value: str) -> str:
    parts = value.split(",")
    if key in _WITH_SETTINGS:
        parts = ["=".join(part.rsplit(":", 1)) for part in parts]
    return f"{key} {(' ' if key in _SPACE_SEPARATED else ',').join(parts)}"
