"""The statistics of rostopic: the rate, delay and size of a topic's messages."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

from rostether.graph.message_windows import (
    DEFAULT_BANDWIDTH_WINDOW,
    DEFAULT_WINDOW,
    DelayWindow,
    IntervalWindow,
    SizeWindow,
    Spread,
    format_bandwidth,
    format_delay,
    format_rate,
    format_rate_table,
)
from rostether.rospy.client.ros_time import get_rostime


class ROSTopicHz:
    """Measures the rate of all received messages, or of each topic if `callback_hz` gets the topic's name."""

    def __init__(
        self, window_size: int, filter_expr: Callable[[Any], object] | None = None, use_wtime: bool = False
    ) -> None:
        self.window_size = DEFAULT_WINDOW if window_size < 0 else window_size
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self.lock = threading.Lock()
        self._windows = defaultdict[str | None, IntervalWindow](
            lambda: IntervalWindow(max(self.window_size, 1))
        )

    @property
    def times(self) -> list[float]:
        """The intervals between messages in seconds."""
        return self.get_times()

    def get_times(self, topic: str | None = None) -> list[float]:
        """Return the intervals between a topic's messages in seconds."""
        return self._windows[topic].intervals_s

    def callback_hz(self, m: Any, topic: str | None = None) -> None:
        """Record a message."""
        if self.filter_expr is not None and not self.filter_expr(m):
            return
        now_s = time.time() if self.use_wtime else get_rostime().to_sec()
        with self.lock:
            if now_s:
                self._windows[topic].add(now_s)
            else:
                # Simulated time is zero before the first /clock, and while a simulation starts again.
                self._windows.pop(topic, None)

    def get_hz(self, topic: str | None = None) -> tuple[float, float, float, float, int] | None:
        """Return rate, shortest and longest interval, deviation, message count; None without new messages."""
        spread = self._report(topic)
        return None if spread is None else (spread.rate_hz, *_without_mean(spread))

    def print_hz(self, topics: tuple[str | None, ...] = (None,)) -> None:
        """Print the rate of each topic."""
        found = {f"{topic}": spread for topic in topics if (spread := self._report(topic)) is not None}
        if not found:
            print("no new messages")
        elif len(topics) > 1:
            print(format_rate_table(found))
        else:
            print(*map(format_rate, found.values()))

    def _report(self, topic: str | None) -> Spread | None:
        with self.lock:
            return self._windows[topic].report()


class ROSTopicDelay:
    """Measures the age of messages on arrival, by the stamps in their headers."""

    def __init__(self, window_size: int) -> None:
        self.window_size = DEFAULT_WINDOW if window_size < 0 else window_size
        self.lock = threading.Lock()
        self._window = DelayWindow(self.window_size)

    def callback_delay(self, msg: Any) -> None:
        """Record a message. Raises RuntimeError for one without a header."""
        if not msg._has_header:
            raise RuntimeError("msg does not have header")
        with self.lock:
            # Subtracted here, because floats of the two times would lose nanoseconds.
            self._window.add((get_rostime() - msg.header.stamp).to_sec(), 0.0)

    def get_delay(self) -> tuple[float, float, float, float, int] | None:
        """Return mean, minimum, maximum, deviation (in s), and count; None without new delays."""
        spread = self._report()
        return None if spread is None else (spread.mean_s, *_without_mean(spread))

    def print_delay(self) -> None:
        """Print the mean, range and deviation of the delays."""
        spread = self._report()
        print("no new messages" if spread is None else format_delay(spread))

    def _report(self) -> Spread | None:
        with self.lock:
            return self._window.report()


class ROSTopicBandwidth:
    """Measures the bandwidth of AnyMsg messages in bytes per second."""

    def __init__(self, window_size: int = DEFAULT_BANDWIDTH_WINDOW) -> None:
        self.window_size = window_size if window_size > 0 else DEFAULT_BANDWIDTH_WINDOW
        self.lock = threading.Lock()
        self._window = SizeWindow(self.window_size)

    @property
    def times(self) -> list[float]:
        """The arrival times of messages in seconds since the epoch."""
        return [when_s for when_s, _ in self._window.arrivals]

    @property
    def sizes(self) -> list[int]:
        """The sizes of the messages in bytes."""
        return [size for _, size in self._window.arrivals]

    def callback(self, data: Any) -> None:
        """Record a message."""
        with self.lock:
            self._window.add(time.time(), len(data._buff))

    def print_bw(self) -> None:
        """Print the bandwidth; nothing before the second message."""
        with self.lock:
            bandwidth = self._window.report(time.time())
        if bandwidth is not None:
            print(format_bandwidth(bandwidth))


def _without_mean(spread: Spread) -> tuple[float, float, float, int]:
    return spread.min_s, spread.max_s, spread.std_dev_s, spread.window
