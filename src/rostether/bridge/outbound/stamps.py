"""Samples the stamps that a board sends, for the estimate of its clock."""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct

from rostether.msgdef.registry import Registry
from rostether.rosserial.clock_estimate import ClockEstimate
from rostether.rosserial.packets import TopicInfo
from rostether.rostime import Time

# With fifty samples a second, at least one in any 0.8 s has little delay, even in a flood.
SAMPLE_PERIOD_S = 0.02

_HEADER = "std_msgs/Header"
_STAMP = Struct("<II")
_SEQUENCE_BYTES = 4
_COUNT_BYTES = 4


class Stamps:
    """Reads the latest message of some chunks, if its type begins with a Header."""

    def __init__(self, estimate: ClockEstimate, now: Callable[[], Time]) -> None:
        self.estimate = estimate

        # The offset of the stamp in the payload, by topic id.
        self.offsets: dict[int, int] = {}
        self._now = now
        self._next_s = 0.0

    def announced(self, info: TopicInfo, registry: Registry) -> None:
        """Record a bridged topic that the board publishes."""
        offset = stamp_offset(registry, info.message_type)
        if offset is None:
            # Another topic may have had the id before.
            self.offsets.pop(info.topic_id, None)
        else:
            self.offsets[info.topic_id] = offset

    def answered(self, time: Time, now_s: float) -> None:
        """Record that the board gets the time."""
        self.estimate.answered(time.to_ns(), now_s)

    def track(self, topic_id: int, payloads: list[bytes], now_s: float) -> None:
        """Handle the messages of a topic that has an offset."""
        if now_s < self._next_s:
            return
        self._next_s = now_s + SAMPLE_PERIOD_S
        payload = payloads[-1]
        offset = self.offsets[topic_id]
        if len(payload) >= offset + _STAMP.size:
            seconds, nanoseconds = _STAMP.unpack_from(payload, offset)
            self.estimate.stamped(seconds * 10**9 + nanoseconds, self._now().to_ns(), now_s)


def stamp_offset(registry: Registry, type_name: str) -> int | None:
    """Return the offset of a type's first stamp, None unless it begins with a Header or a list of Headers."""
    fields = registry.message(type_name).fields
    if not fields:
        return None
    first = fields[0].type
    if first.base == _HEADER:
        return None if first.is_array else _SEQUENCE_BYTES
    if not first.is_array or first.length is not None or "/" not in first.base:
        return None
    inner = registry.message(first.base).fields
    holds_header = bool(inner) and inner[0].type.base == _HEADER and not inner[0].type.is_array
    return _COUNT_BYTES + _SEQUENCE_BYTES if holds_header else None


def has_header(registry: Registry, type_name: str) -> bool:
    """Return whether a type begins with a field `header`, in which ROS clients count messages."""
    fields = registry.message(type_name).fields
    return (
        bool(fields)
        and (fields[0].name, fields[0].type.base) == ("header", _HEADER)
        and not fields[0].type.is_array
    )
