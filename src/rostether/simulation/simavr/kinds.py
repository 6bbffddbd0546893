"""The boards that can be simulated, and their kinds in the runner."""

from __future__ import annotations

from rostether.errors import ConfigError
from rostether.simulation.qemu import MACHINES

KINDS = {
    "uno": "uno",
    "nano": "nano",
    "promini": "nano",
    "mega": "mega",
    "leonardo": "leonardo",
    "micro": "leonardo",
}


def kind_of(board: str) -> str:
    """Return the runner's name for a board. Raises ConfigError with the known boards."""
    try:
        return KINDS[board]
    except KeyError:
        known = ", ".join((*KINDS, "opencr", *MACHINES))
        raise ConfigError(f"no simulated board {board!r}; known: {known}") from None
