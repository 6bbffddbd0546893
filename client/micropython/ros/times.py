"""The field types `time` and `duration`."""

from struct import pack_into, unpack_from

_NSEC = 1_000_000_000


class _Seconds:
    """The common base of Time and Duration."""

    def __init__(self, sec=0, nsec=0):
        self.sec = sec + nsec // _NSEC
        self.nsec = nsec % _NSEC

    def toSec(self):
        """Return seconds. A float of 4 bytes has a resolution of about two minutes for current times."""
        return self.sec + self.nsec / _NSEC

    def serialize(self, writer):
        """Write 8 bytes."""
        pack_into(self._FORMAT, writer.buffer, writer.room(8), self.sec, self.nsec)

    def deserialize(self, reader):
        """Read 8 bytes."""
        self.sec, self.nsec = unpack_from(self._FORMAT, reader.buffer, reader.skip(8))

    def __eq__(self, other):
        return self.sec == other.sec and self.nsec == other.nsec

    def __lt__(self, other):
        return self.sec < other.sec or (self.sec == other.sec and self.nsec < other.nsec)


class Time(_Seconds):
    """A time: `sec` + `nsec` * 1e-9 seconds since 1970, with `nsec` < 1e9."""

    _FORMAT = "<II"

    def __add__(self, span):
        return Time(self.sec + span.sec, self.nsec + span.nsec)

    def __sub__(self, other):
        """Return the Duration since another Time, or the Time before a Duration."""
        made = Duration if isinstance(other, Time) else Time
        return made(self.sec - other.sec, self.nsec - other.nsec)


class Duration(_Seconds):
    """A duration, which may be negative: `sec` + `nsec` * 1e-9 seconds, with 0 <= `nsec` < 1e9."""

    _FORMAT = "<ii"
