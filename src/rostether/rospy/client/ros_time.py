"""rospy.Time and rospy.Duration, ROS time, and the functions that wait for it."""

from __future__ import annotations

import threading
import time
from typing import Any

from msgspec import Struct

from rostether.rospy.client import stamps
from rostether.rospy.client.exceptions import (
    ROSInitException,
    ROSInterruptException,
    ROSTimeMovedBackwardsException,
)
from rostether.rospy.client.node import node
from rostether.rospy.client.shutdown import is_shutdown, shutdown
from rostether.rostime import NS_PER_S

# The interval of checks of simulated time, which usually changes a hundred times a second.
SIMULATED_POLL_S = 0.002

# Whether the program may read the wall clock without a node.
_initialized = False


class Duration(stamps.Duration):
    """A span of time."""

    __slots__ = ()
    _class_text = "rospy.Duration"


class Time(stamps.Time):
    """A point in ROS time."""

    __slots__ = ()
    _class_text = "rospy.Time"

    @staticmethod
    def now() -> Time:
        """Return ROS time: the wall clock or /clock. Raises ROSInitException before init_node."""
        return get_rostime()

    @classmethod
    def from_seconds(cls, float_secs: float) -> Time:
        """Create a time from seconds; the older name of `from_sec`."""
        return cls.from_sec(float_secs)


def is_wallclock() -> bool:
    """Return whether ROS time is the time of the wall clock."""
    return not (node.is_initialized and node.graph.is_time_simulated)


def set_rostime_initialized(val: bool) -> None:
    """Set whether a program without a node may read the wall clock."""
    global _initialized
    _initialized = val


def is_rostime_initialized() -> bool:
    """Return whether a program can read ROS time."""
    return node.is_initialized or _initialized


def get_rostime() -> Time:
    """Return ROS time. Raises ROSInitException before init_node."""
    if not is_rostime_initialized():
        raise ROSInitException("time is not initialized. Have you called init_node()?")
    if not is_wallclock():
        return Time(*node.graph.now())
    return Time(*divmod(time.time_ns(), NS_PER_S))


def get_time() -> float:
    """Return ROS time in seconds. Raises ROSInitException before init_node."""
    return get_rostime().to_sec()


def simulated_time_s() -> float | None:
    """Return simulated ROS time in seconds; None if ROS time is the wall clock."""
    return None if is_wallclock() else get_time()


def sleep(duration: Any) -> None:
    """Sleep for seconds or a Duration of ROS time, at most until the shutdown.

    In simulated time, raises ROSTimeMovedBackwardsException if time moves back, and ROSInterruptException at
    the shutdown.
    """
    seconds = float(stamps.in_seconds(duration))
    if is_wallclock():
        if seconds > 0:
            shutdown.event.wait(seconds)
        return
    start = get_time()
    while start == 0 and not shutdown.event.wait(SIMULATED_POLL_S):
        # Simulated time is zero before the first /clock.
        start = get_time()
    end = start + seconds
    now = start
    while now < end and not shutdown.event.wait(SIMULATED_POLL_S):
        now = get_time()
        if now < start:
            raise ROSTimeMovedBackwardsException(start - now)
    if is_shutdown():
        raise ROSInterruptException("ROS shutdown request")


def wallsleep(duration: float) -> None:
    """Sleep for seconds of the wall clock, at most until the shutdown."""
    if duration > 0:
        shutdown.event.wait(duration)


class Rate:
    """Sleeps so that a loop runs `hz` times a second."""

    def __init__(self, hz: float, reset: bool = False) -> None:
        self.last_time = get_rostime()
        self.sleep_dur = Duration(0, int(NS_PER_S / hz))
        self._reset = reset

    def remaining(self) -> Any:
        """Return how long the next sleep will be."""
        return self._remaining(get_rostime())

    def sleep(self) -> None:
        """Sleep until the next cycle is due; after a delay of two cycles, restart at the current time."""
        now = get_rostime()
        try:
            sleep(self._remaining(now))
        except ROSTimeMovedBackwardsException:
            if not self._reset:
                raise
            self.last_time = get_rostime()
            return
        self.last_time = self.last_time + self.sleep_dur
        if now - self.last_time > self.sleep_dur * 2:
            self.last_time = now

    def _remaining(self, now: Time) -> Any:
        self.last_time = min(self.last_time, now)
        return self.sleep_dur - (now - self.last_time)


class TimerEvent(Struct, dict=True, eq=False):
    """The argument of a timer's callback: the expected and real times of this call and of the last one.

    `last_duration` is the time in seconds that the last callback took.
    """

    last_expected: Time | None
    last_real: Time | None
    current_expected: Time
    current_real: Time
    last_duration: float | None


class Timer(threading.Thread):
    """Calls back with a TimerEvent in its own thread: every `period`, or once with `oneshot`."""

    def __init__(self, period: Any, callback: Any, oneshot: bool = False, reset: bool = False) -> None:
        super().__init__(daemon=True)
        self._period = period
        self._callback = callback
        self._oneshot = oneshot
        self._reset = reset
        self._is_shut_down = False
        self.start()

    def shutdown(self) -> None:
        """Stop calling back."""
        self._is_shut_down = True

    def run(self) -> None:
        """Call back until `shutdown`."""
        rate = Rate(1.0 / self._period.to_sec(), reset=self._reset)
        expected = get_rostime() + self._period
        last_expected: Time | None = None
        last_real: Time | None = None
        last_duration: float | None = None
        while not is_shutdown() and not self._is_shut_down:
            try:
                rate.sleep()
            except ROSInterruptException:
                if is_shutdown():
                    return
                raise
            if self._is_shut_down or is_shutdown():
                return
            real = get_rostime()
            start_s = time.time()
            self._callback(TimerEvent(last_expected, last_real, expected, real, last_duration))
            if self._oneshot:
                return
            last_duration = time.time() - start_s
            last_expected, last_real = expected, real
            expected = expected + self._period
