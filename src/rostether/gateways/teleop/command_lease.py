"""Decides which client drives a robot, and when the robot must stop; without I/O."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar

DriverT = TypeVar("DriverT", bound=Hashable)

# The dashboard sends 25 commands a second: two in a row may be lost.
KEEP_S = 0.125

# Lifting a finger for a moment does not pass the robot to another client.
HOLD_S = 1.0


class CommandLease(Generic[DriverT]):
    """The lease of one command topic. Times are seconds of a monotonic clock."""

    def __init__(self) -> None:
        self.driver: DriverT | None = None
        self._commanded_s = 0.0
        self._is_moving = False
        self._has_stopped = True
        # Drivers that were silent for `HOLD_S` while they moved the robot.
        self._lapsed: set[DriverT] = set()

    @property
    def due_s(self) -> float | None:
        """When `expire` must be called; None if not at all."""
        if self.driver is None:
            return None
        return self._commanded_s + (KEEP_S if self._is_moving else HOLD_S)

    def admits(self, driver: DriverT, now_s: float, *, is_stop: bool) -> bool:
        """Return whether a driver's command may be published: every stop, and commands of the lease's driver.

        A driver that was silent for `HOLD_S` while it moved the robot must send a stop first: after a network
        stalls, the commands of that time arrive at once, and must not start the robot.
        """
        if is_stop:
            return True
        if self.driver is None:
            return driver not in self._lapsed
        # `expire` may be late in a busy process.
        is_silent = now_s >= self._commanded_s + HOLD_S
        return driver == self.driver and (self._has_stopped or not is_silent)

    def command(self, driver: DriverT, now_s: float, *, is_stop: bool) -> None:
        """Give the lease to the driver of an admitted command, and keep it for this driver."""
        self.driver = driver
        self._commanded_s = now_s
        self._has_stopped = is_stop
        self._is_moving = not is_stop
        self._lapsed.discard(driver)

    def expire(self, now_s: float) -> bool:
        """Handle the expired times; return whether a stop must be published now."""
        must_stop = False
        if self._is_moving and now_s >= self._commanded_s + KEEP_S:
            self._is_moving = False
            must_stop = True
        if self.driver is not None and now_s >= self._commanded_s + HOLD_S:
            if not self._has_stopped:
                self._lapsed.add(self.driver)
            self.driver = None
        return must_stop

    def release(self, driver: DriverT) -> bool:
        """Free the lease if it is this driver's; return whether a stop must be published now."""
        self._lapsed.discard(driver)
        if self.driver != driver:
            return False
        must_stop, self._is_moving, self.driver = self._is_moving, False, None
        return must_stop
