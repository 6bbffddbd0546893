"""ROS time of a node: the wall clock, or the messages of /clock."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Sequence

from rostether.rostime import Time

_CLOCK = struct.Struct("<II")


def _wall_time() -> Time:
    return Time.from_ns(time.time_ns())


class Clock:
    """Returns ROS time; whether it is simulated is decided once, when the node joins, as in rospy."""

    def __init__(self, wall_time: Callable[[], Time] = _wall_time) -> None:
        self._wall_time = wall_time
        self._simulated: Time | None = None

    def simulate(self) -> None:
        """From now on, use the time from `handle_messages`; it is zero before the first."""
        self._simulated = Time()

    @property
    def is_simulated(self) -> bool:
        """Whether the time comes from /clock."""
        return self._simulated is not None

    def now(self) -> Time:
        """Return the time."""
        return self._wall_time() if self._simulated is None else self._simulated

    def handle_messages(self, payloads: Sequence[bytes]) -> None:
        """Handle serialized rosgraph_msgs/Clock messages; a malformed one is ignored."""
        if len(payloads[-1]) == _CLOCK.size:
            self._simulated = Time(*_CLOCK.unpack(payloads[-1]))
