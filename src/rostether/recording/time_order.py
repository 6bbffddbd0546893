"""Detects messages whose time goes back, such as after the reset of a simulation."""

from __future__ import annotations

from rostether.rostime import NS_PER_S

# Smaller steps back are not resets: threads and NTP corrections also cause them.
_JUMP_NS = NS_PER_S


class TimeOrder:
    """Checks the times of messages in the order of the file."""

    def __init__(self) -> None:
        self._last_ns = 0
        self._count = 0
        self._first = ""

    def add(self, time_ns: int) -> None:
        """Record the next message's time."""
        if time_ns < self._last_ns - _JUMP_NS:
            self._count += 1
            if not self._first:
                self._first = f"from {self._last_ns / NS_PER_S:.2f} s to {time_ns / NS_PER_S:.2f} s"
        self._last_ns = time_ns

    @property
    def fault(self) -> str:
        """The problem to report, or an empty string."""
        if not self._count:
            return ""
        times = "once" if self._count == 1 else f"{self._count} times, first"
        return (
            f"its time goes back {times} {self._first}, for instance because a simulation was reset; "
            "`rostether bag filter FILE NEW_FILE True` sorts the messages"
        )
