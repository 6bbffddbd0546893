"""The message rates of a recording's topics, in memory that does not grow with the recording."""

from __future__ import annotations

from array import array

from rostether.mechanisms.median import median
from rostether.recording.recorded import RecordingReader, Wanted
from rostether.rostime import Time

# 2 MB for each topic. The median of this sample differs from that of all messages by less than a percent.
MAX_PERIODS = 262_144


def message_rates_hz(reader: RecordingReader, wanted: Wanted | None = None) -> dict[str, float]:
    """Return the rate of each topic that has one: the inverse of the median time between two messages.

    Raises RecordingError.
    """
    periods: dict[str, _Periods] = {}
    for message in reader.messages(wanted):
        # Times are floats, so that the digits are the same as rosbag's.
        time_s = Time.from_ns(message.time_ns).to_s()
        periods.setdefault(message.connection.topic, _Periods()).add(time_s)
    medians_s = {topic: median(each.kept) for topic, each in periods.items() if each.kept}
    return {topic: 1 / period_s for topic, period_s in medians_s.items() if period_s > 0}


class _Periods:
    """The times between messages of a topic, in s: all, or at most MAX_PERIODS of them, evenly spaced."""

    def __init__(self) -> None:
        self.kept = array("d")
        self._last_s: float | None = None
        self._stride = 1
        self._count = 0

    def add(self, time_s: float) -> None:
        """Count a message that was recorded at this time."""
        if self._last_s is not None:
            if self._count % self._stride == 0:
                self.kept.append(time_s - self._last_s)
            self._count += 1
        self._last_s = time_s
        if len(self.kept) > MAX_PERIODS:
            del self.kept[1::2]
            self._stride *= 2
