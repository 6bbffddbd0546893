"""Translates the options in the link address of a simulated board to commands of that board.

In an address `=` and `&` separate options, so a `=` within a value is written `:`, and a space as a comma:
`adc=A0:2.5,A1:1` is the word `adc A0=2.5 A1=1`, `fault=to:flip:0.01,seed:3` is `fault to:flip=0.01,seed=3`.
"""

from __future__ import annotations

from collections.abc import Mapping

SIM_WORDS = (
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
_OF_SEVERAL_WORDS = ("adc", "attitude", "pin", "servo", "watch")
_WITH_SETTINGS = ("adc", "fault", "hcsr04", "pin", "w5100", "wheels")


def sim_words(options: Mapping[str, str]) -> tuple[str, ...]:
    """Return the commands for the board from an address's options, in the same order."""
    return tuple(_line(key, value) for key, value in options.items() if key in SIM_WORDS)


def _line(key: str, value: str) -> str:
    parts = value.split(",")
    if key in _WITH_SETTINGS:
        parts = ["=".join(part.rsplit(":", 1)) for part in parts]
    return f"{key} {(' ' if key in _OF_SEVERAL_WORDS else ',').join(parts)}"
