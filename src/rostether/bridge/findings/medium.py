"""The medium between a board and this machine, which decides what its faults mean."""

from __future__ import annotations

from enum import Enum, auto


class Medium(Enum):
    """The medium between a board and this machine, which decides what its faults mean.

    SERIAL includes pseudo-terminals; RADIO is an XBee network.
    """

    SERIAL = auto()
    TCP = auto()
    UDP = auto()
    RADIO = auto()

    @property
    def may_lose(self) -> bool:
        """Whether whole frames may be lost or delayed."""
        return self in (Medium.UDP, Medium.RADIO)
