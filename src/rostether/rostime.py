"""ROS time and duration: seconds and nanoseconds as on the wire, and their arithmetic."""

from __future__ import annotations

from typing import NamedTuple

NS_PER_S = 1_000_000_000


class Time(NamedTuple):
    """A point in time, `secs` and `nsecs` both uint32 (source: std_msgs/Time)."""

    secs: int = 0
    nsecs: int = 0

    @classmethod
    def from_ns(cls, ns: int) -> Time:
        """Build from nanoseconds since the epoch; negative values become zero, the wire has no sign."""
        return cls(*divmod(max(ns, 0), NS_PER_S))

    @classmethod
    def from_s(cls, seconds: float) -> Time:
        """Build from seconds since the epoch, rounded to the nearest nanosecond."""
        return cls.from_ns(round(seconds * NS_PER_S))

    def to_ns(self) -> int:
        """Return nanoseconds since the epoch."""
        return self.secs * NS_PER_S + self.nsecs

    def to_s(self) -> float:
        """Return seconds since the epoch."""
        return self.secs + self.nsecs / NS_PER_S


class Duration(NamedTuple):
    """A signed span, `secs` and `nsecs` both int32, 0 <= nsecs < 1e9 (source: std_msgs/Duration)."""

    secs: int = 0
    nsecs: int = 0

    @classmethod
    def from_ns(cls, ns: int) -> Duration:
        """Build from a signed count of nanoseconds."""
        return cls(*divmod(ns, NS_PER_S))

    @classmethod
    def from_s(cls, seconds: float) -> Duration:
        """Build from seconds, rounded to the nearest nanosecond."""
        return cls.from_ns(round(seconds * NS_PER_S))

    def to_ns(self) -> int:
        """Return the span in nanoseconds."""
        return self.secs * NS_PER_S + self.nsecs

    def to_s(self) -> float:
        """Return the span in seconds."""
        return self.secs + self.nsecs / NS_PER_S
