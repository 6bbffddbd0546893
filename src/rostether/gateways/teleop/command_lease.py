"""Decides which client may drive, and when a command is too old; without I/O.

    free -- command --> driving -- no command for KEEP_S --> stopped -- no command for HOLD_S --> free
                           ^------------- command ---------------'

A driver that leaves frees the lease at once. Every client may stop the robot; it holds the lease then.
"""

from __future__ import annotations

from collections.abc import Hashable

# Pages send 20 commands a second; the robot must stop after two and a half missing commands.
KEEP_S = 0.125

# Lifting a finger for a moment does not pass the robot to another client.
HOLD_S = 1.0


class CommandLease:
    """The lease of one command topic. Times are seconds of any clock that never jumps."""

    def __init__(self) -> None:
        self.driver: Hashable | None = None
        self._commanded_s = 0.0
        self._is_moving = False

    @property
    def due_s(self) -> float | None:
        """When `expire` must be called; None if not at all."""
        if self.driver is None:
            return None
        return self._commanded_s + (KEEP_S if self._is_moving else HOLD_S)

    def command(self, driver: Hashable, now_s: float, *, is_stop: bool) -> bool:
        """Return whether a driver's command may be published, and keep the lease for it."""
        if self.driver is None:
            self.driver = driver
        elif self.driver != driver:
            if not is_stop:
                return False
            self.driver = driver
        self._commanded_s = now_s
        self._is_moving = not is_stop
        return True

    def expire(self, now_s: float) -> bool:
        """Handle what is due; returns whether a stop must be published now."""
        must_stop = False
        if self._is_moving and now_s >= self._commanded_s + KEEP_S:
            self._is_moving = False
            must_stop = True
        if self.driver is not None and now_s >= self._commanded_s + HOLD_S:
            self.driver = None
        return must_stop

    def release(self, driver: Hashable) -> bool:
        """Free the lease if it is this driver's; returns whether a stop must be published now."""
        if self.driver != driver:
            return False
        must_stop, self._is_moving, self.driver = self._is_moving, False, None
        return must_stop
