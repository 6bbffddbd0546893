"""Times and durations of messages, as in genpy: mutable, with arithmetic, compared only with their kind.

Source: http://docs.ros.org/en/noetic/api/genpy/html/
"""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any, ClassVar, TypeVar

from rostether.rostime import NS_PER_S

_T = TypeVar("_T", bound="TVal")


class TVal:
    """Seconds and nanoseconds, 0 <= nsecs < 1e9; `secs` alone may be a float."""

    __slots__ = ("nsecs", "secs")
    _class_text: ClassVar = "genpy.TVal"
    _slot_types = ["int32", "int32"]  # noqa: RUF012 - a list, as introspection of messages expects

    def __init__(self, secs: Any = 0, nsecs: Any = 0) -> None:
        if not isinstance(secs, Integral):
            if nsecs != 0:
                raise ValueError("if secs is a float, nsecs cannot be set")
            secs, nsecs = _split_s(secs)
        self.secs, self.nsecs = _carry(int(secs), int(nsecs))

    @classmethod
    def from_sec(cls: type[_T], float_secs: float) -> _T:
        """Create a stamp from seconds; fractions of a nanosecond are cut off."""
        return cls(*_split_s(float_secs))

    def is_zero(self) -> bool:
        """Return whether both fields are zero."""
        return self.secs == 0 and self.nsecs == 0

    def set(self, secs: int, nsecs: int) -> None:
        """Set both fields without a check."""
        self.secs = secs
        self.nsecs = nsecs

    def canon(self) -> None:
        """Normalize the fields, so that nsecs is below a second."""
        self.secs, self.nsecs = _carry(self.secs, self.nsecs)

    def to_sec(self) -> float:
        """Return the value in seconds."""
        return float(self.secs) + float(self.nsecs) / 1e9

    def to_nsec(self) -> int:
        """Return the value in nanoseconds."""
        return self.secs * NS_PER_S + self.nsecs

    def __hash__(self) -> int:
        return hash((self.secs, self.nsecs))

    def __str__(self) -> str:
        return str(self.to_nsec())

    def __repr__(self) -> str:
        return f"{self._class_text}[{self.to_nsec()}]"

    def __bool__(self) -> bool:
        return not self.is_zero()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _kind(self)) and (self.secs, self.nsecs) == (other.secs, other.nsecs)

    def __lt__(self, other: object) -> bool:
        return self.to_nsec() < other.to_nsec() if isinstance(other, _kind(self)) else NotImplemented

    def __le__(self, other: object) -> bool:
        return self.to_nsec() <= other.to_nsec() if isinstance(other, _kind(self)) else NotImplemented

    def __gt__(self, other: object) -> bool:
        return self.to_nsec() > other.to_nsec() if isinstance(other, _kind(self)) else NotImplemented

    def __ge__(self, other: object) -> bool:
        return self.to_nsec() >= other.to_nsec() if isinstance(other, _kind(self)) else NotImplemented

    def __getstate__(self) -> list[int]:
        return [self.secs, self.nsecs]

    def __setstate__(self, state: list[int]) -> None:
        self.secs, self.nsecs = state

    def __add__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return type(self)(self.secs + other.secs, self.nsecs + other.nsecs)
        return NotImplemented

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return type(self)(self.secs - other.secs, self.nsecs - other.nsecs)
        return NotImplemented


class Time(TVal):
    """A point in time. Raises TypeError for a negative one."""

    __slots__ = ()
    _class_text = "genpy.Time"

    def __init__(self, secs: Any = 0, nsecs: Any = 0) -> None:
        super().__init__(secs, nsecs)
        if self.secs < 0:
            raise TypeError("time values must be positive")

    def to_time(self) -> float:
        """Return the seconds since the epoch, like `time.time()`."""
        return self.to_sec()

    def __sub__(self, other: object) -> Any:
        if isinstance(other, Time):
            return Duration(self.secs - other.secs, self.nsecs - other.nsecs)
        return super().__sub__(other)


class Duration(TVal):
    """A span of time, which may be negative."""

    __slots__ = ()
    _class_text = "genpy.Duration"

    def __neg__(self) -> Any:
        return type(self)(-self.secs, -self.nsecs)

    def __abs__(self) -> Any:
        return self if self.secs >= 0 else -self

    def __mul__(self, factor: Any) -> Any:
        if isinstance(factor, Integral):
            return type(self)(self.secs * int(factor), self.nsecs * int(factor))
        if isinstance(factor, Real):
            return self.from_sec(self.to_sec() * float(factor))
        return NotImplemented

    __rmul__ = __mul__

    def __floordiv__(self, divisor: Any) -> Any:
        if isinstance(divisor, Duration):
            return int(self.to_sec() // divisor.to_sec())
        return self.from_sec(self.to_sec() // float(divisor)) if isinstance(divisor, Real) else NotImplemented

    def __truediv__(self, divisor: Any) -> Any:
        if isinstance(divisor, Duration):
            return self.to_sec() / divisor.to_sec()
        return self.from_sec(self.to_sec() / float(divisor)) if isinstance(divisor, Real) else NotImplemented

    def __mod__(self, divisor: object) -> Any:
        if isinstance(divisor, Duration):
            return self.from_sec(self.to_sec() % divisor.to_sec())
        return NotImplemented

    def __divmod__(self, divisor: object) -> Any:
        if isinstance(divisor, Duration):
            quotient, remainder = divmod(self.to_sec(), divisor.to_sec())
            return int(quotient), self.from_sec(remainder)
        return NotImplemented


def in_seconds(value: Any) -> Any:
    """Return a Duration in seconds, and any other value, such as a number of seconds, unchanged."""
    return value.to_sec() if isinstance(value, Duration) else value


def new_stamp(stamp_class: type[TVal], fields: tuple[int, int]) -> TVal:
    """Create a stamp from the two fields on the wire, without a check."""
    stamp = object.__new__(stamp_class)
    stamp.secs, stamp.nsecs = fields
    return stamp


def _kind(stamp: TVal) -> type[TVal]:
    """Return the class that a stamp compares with: times with times, durations with durations."""
    return Time if isinstance(stamp, Time) else Duration if isinstance(stamp, Duration) else TVal


def _split_s(seconds: Any) -> tuple[int, int]:
    whole = int(seconds)
    # Truncated, not rounded, so that inexact floats give the same result as in rospy.
    return whole, int((seconds - whole) * NS_PER_S)


def _carry(secs: int, nsecs: int) -> tuple[int, int]:
    over, nsecs = divmod(nsecs, NS_PER_S)
    return secs + over, nsecs
