"""The stored transforms of one frame to its parent, sorted by time; old ones are deleted."""

from __future__ import annotations

from bisect import bisect_left

from msgspec import Struct

from rostether.errors import ExtrapolationError
from rostether.robot.transform import Transform, interpolate
from rostether.rostime import NS_PER_S

# The default history length of tf2.
DEFAULT_CACHE_NS = 10 * NS_PER_S

# The limit for one frame: ten seconds at 10 kHz, more than any sensor sends. The time limit alone would not
# stop a hostile peer.
MAX_TRANSFORMS = 100_000

# The shortest assumed span, as in tf2: a single transform has a rate, too.
_SHORTEST_SPAN_S = 0.0001


class StoredTransform(Struct, frozen=True):
    """One transform of a frame to its parent."""

    stamp_ns: int
    parent: str
    transform: Transform
    authority: str


class TimeCache:
    """The moving transforms of one frame. Stamps are in nanoseconds; zero means the latest."""

    is_static = False

    def __init__(self, cache_ns: int = DEFAULT_CACHE_NS) -> None:
        self._cache_ns = cache_ns
        self._stamps: list[int] = []
        self._entries: list[StoredTransform] = []

    def insert(self, entry: StoredTransform) -> str:
        """Store an entry; return tf2's error message if it was refused, or an empty string."""
        stamps = self._stamps
        if stamps and stamps[-1] > entry.stamp_ns + self._cache_ns:
            return (
                "TF_OLD_DATA ignoring data from the past (Possible reasons are listed at "
                "http://wiki.ros.org/tf/Errors%20explained)"
            )
        index = bisect_left(stamps, entry.stamp_ns)
        if index < len(stamps) and stamps[index] == entry.stamp_ns:
            return "TF_REPEATED_DATA ignoring data with redundant timestamp"
        stamps.insert(index, entry.stamp_ns)
        self._entries.insert(index, entry)
        outdated = max(bisect_left(stamps, stamps[-1] - self._cache_ns), len(stamps) - MAX_TRANSFORMS)
        if outdated:
            del stamps[:outdated]
            del self._entries[:outdated]
        return ""

    def at(self, time_ns: int) -> StoredTransform:
        """Return the transform at a time, interpolated between two entries with the same parent.

        If the parent changes between them, returns the earlier entry. Raises ExtrapolationError.
        """
        stamps = self._stamps
        if time_ns == 0:
            return self._entries[-1]
        if not stamps[0] <= time_ns <= stamps[-1]:
            raise ExtrapolationError(_out_of_range(time_ns, stamps))
        index = bisect_left(stamps, time_ns)
        later = self._entries[index]
        if later.stamp_ns == time_ns:
            return later
        earlier = self._entries[index - 1]
        if earlier.parent != later.parent:
            return earlier
        ratio = (time_ns - earlier.stamp_ns) / (later.stamp_ns - earlier.stamp_ns)
        moved = interpolate(earlier.transform, later.transform, ratio)
        return StoredTransform(time_ns, later.parent, moved, later.authority)

    @property
    def latest(self) -> StoredTransform:
        """The newest entry."""
        return self._entries[-1]

    @property
    def latest_ns(self) -> int:
        """The stamp of the newest entry."""
        return self._stamps[-1]

    @property
    def oldest_ns(self) -> int:
        """The stamp of the oldest entry."""
        return self._stamps[0]

    @property
    def rate_hz(self) -> float:
        """Entries per second over the stored span, as tf2 counts them."""
        return len(self._stamps) / max((self.latest_ns - self.oldest_ns) / NS_PER_S, _SHORTEST_SPAN_S)


class StaticCache:
    """The transform of a frame that never moves: the last one received is valid at all times."""

    is_static = True
    latest_ns = 0
    oldest_ns = 0
    rate_hz = 1 / _SHORTEST_SPAN_S

    def __init__(self, entry: StoredTransform) -> None:
        self.latest = entry

    def insert(self, entry: StoredTransform) -> str:
        """Replace the transform; never refuses."""
        self.latest = entry
        return ""

    def at(self, time_ns: int) -> StoredTransform:
        """Return the transform."""
        return self.latest


def _out_of_range(time_ns: int, stamps: list[int]) -> str:
    asked = seconds(time_ns)
    if len(stamps) == 1:
        only = seconds(stamps[0])
        return f"Lookup would require extrapolation at time {asked}, but only time {only} is in the buffer"
    if time_ns > stamps[-1]:
        return (
            f"Lookup would require extrapolation {seconds(time_ns - stamps[-1])}s into the future.  "
            f"Requested time {asked} but the latest data is at time {seconds(stamps[-1])}"
        )
    return (
        f"Lookup would require extrapolation {seconds(stamps[0] - time_ns)}s into the past.  "
        f"Requested time {asked} but the earliest data is at time {seconds(stamps[0])}"
    )


def seconds(time_ns: int) -> str:
    """Return nanoseconds as the exact text of seconds, with nine decimals."""
    return f"{time_ns // NS_PER_S}.{time_ns % NS_PER_S:09d}"
