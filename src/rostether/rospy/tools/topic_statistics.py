"""The statistics of rostopic: the rate, delay and size of a topic's messages."""

from __future__ import annotations

import math
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable
from typing import Any

from rostether.rospy.client.ros_time import get_rostime

# As in rostopic: the number of messages that are measured without a window.
MAX_WINDOW = 50_000


class ROSTopicHz:
    """Measures the rate of all received messages, or of each topic if `callback_hz` gets the topic's name."""

    def __init__(
        self, window_size: int, filter_expr: Callable[[Any], object] | None = None, use_wtime: bool = False
    ) -> None:
        self.window_size = MAX_WINDOW if window_size < 0 else window_size
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self.lock = threading.Lock()
        self._steps: defaultdict[str | None, deque[float]] = defaultdict(
            lambda: deque(maxlen=max(self.window_size - 1, 0))
        )
        self._last: dict[str | None, float] = {}
        self._shown: dict[str | None, float] = {}

    @property
    def times(self) -> list[float]:
        """The intervals between messages in seconds."""
        return self.get_times()

    def get_times(self, topic: str | None = None) -> list[float]:
        """Return the intervals between a topic's messages in seconds."""
        return list(self._steps[topic])

    def callback_hz(self, m: Any, topic: str | None = None) -> None:
        """Record a message."""
        if self.filter_expr is not None and not self.filter_expr(m):
            return
        now = time.time() if self.use_wtime else get_rostime().to_sec()
        with self.lock:
            if not now:
                self._steps[topic].clear()
                return
            last = self._last.get(topic)
            self._last[topic] = now
            if last is None or now < last:
                self._steps[topic].clear()
            else:
                self._steps[topic].append(now - last)

    def get_hz(self, topic: str | None = None) -> tuple[float, float, float, float, int] | None:
        """Return rate, shortest and longest interval, deviation, message count; None without new messages."""
        with self.lock:
            steps = list(self._steps[topic])
            last = self._last.get(topic)
            if not steps or last is None or last == self._shown.get(topic):
                return None
            self._shown[topic] = last
        mean = sum(steps) / len(steps)
        deviation = math.sqrt(sum((step - mean) ** 2 for step in steps) / len(steps))
        return (1 / mean if mean > 0 else 0), min(steps), max(steps), deviation, len(steps) + 1

    def print_hz(self, topics: tuple[str | None, ...] = (None,)) -> None:
        """Print the rate of each topic."""
        for topic in topics:
            found = self.get_hz(topic)
            if found is None:
                print("no new messages")
                continue
            rate, minimum, maximum, deviation, count = found
            if len(topics) > 1:
                print(topic)
            print(
                f"average rate: {rate:.3f}\n\tmin: {minimum:.3f}s max: {maximum:.3f}s "
                f"std dev: {deviation:.5f}s window: {count}"
            )


class ROSTopicDelay:
    """Measures the age of messages on arrival, by the stamps in their headers."""

    def __init__(self, window_size: int) -> None:
        self.window_size = MAX_WINDOW if window_size < 0 else window_size
        self.lock = threading.Lock()
        self._delays: deque[float] = deque(maxlen=self.window_size)
        self._is_new = False

    def callback_delay(self, msg: Any) -> None:
        """Record a message. Raises RuntimeError for one without a header."""
        if not msg._has_header:
            raise RuntimeError("msg does not have header")
        with self.lock:
            self._delays.append((get_rostime() - msg.header.stamp).to_sec())
            self._is_new = True

    def get_delay(self) -> tuple[float, float, float, float, int] | None:
        """Return mean, minimum, maximum, deviation (in s), and count; None without new delays."""
        with self.lock:
            if not self._is_new:
                return None
            self._is_new = False
            delays = list(self._delays)
        mean = sum(delays) / len(delays)
        deviation = math.sqrt(sum((delay - mean) ** 2 for delay in delays) / len(delays))
        return mean, min(delays), max(delays), deviation, len(delays)

    def print_delay(self) -> None:
        """Print the mean, range and deviation of the delays."""
        found = self.get_delay()
        if found is None:
            print("no new messages")
            return
        mean, minimum, maximum, deviation, count = found
        print(
            f"average delay: {mean:.3f}\n\tmin: {minimum:.3f}s max: {maximum:.3f}s "
            f"std dev: {deviation:.5f}s window: {count}"
        )


class ROSTopicBandwidth:
    """Measures the bandwidth of AnyMsg messages in bytes per second."""

    def __init__(self, window_size: int = 100) -> None:
        self.window_size = window_size if window_size > 0 else 100
        self.lock = threading.Lock()
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=self.window_size)

    @property
    def times(self) -> list[float]:
        """The arrival times of messages in seconds since the epoch."""
        return [when for when, _ in self._arrivals]

    @property
    def sizes(self) -> list[int]:
        """The sizes of the messages in bytes."""
        return [size for _, size in self._arrivals]

    def callback(self, data: Any) -> None:
        """Record a message."""
        with self.lock:
            self._arrivals.append((time.time(), len(data._buff)))

    def print_bw(self) -> None:
        """Print the bandwidth; nothing before the second message."""
        with self.lock:
            arrivals = list(self._arrivals)
        if len(arrivals) < 2:
            return
        sizes = [size for _, size in arrivals]
        per_second = sum(sizes) / max(time.time() - arrivals[0][0], 1e-9)
        unit, divisor = next(
            (unit, divisor)
            for unit, divisor, limit in (("B", 1, 1e3), ("KB", 1e3, 1e6), ("MB", 1e6, math.inf))
            if per_second < limit
        )
        rate, mean, minimum, maximum = (
            f"{value / divisor:.2f}{unit}"
            for value in (per_second, sum(sizes) / len(sizes), min(sizes), max(sizes))
        )
        print(f"average: {rate}/s\n\tmean: {mean} min: {minimum} max: {maximum} window: {len(sizes)}")
