"""ROS time of a node: the wall clock, or the messages of /clock."""

from __future__ import annotations

from collections.abc import Sequence

from rostether.graph.ros_clock import decode_clock, wall_time
from rostether.rostime import Time


class Clock:
    """Returns ROS time; whether it is simulated is decided once, when the node joins, as in rospy."""

    def __init__(self) -> None:
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
        return wall_time() if self._simulated is None else self._simulated

    def handle_messages(self, payloads: Sequence[bytes]) -> None:
        """Handle serialized rosgraph_msgs/Clock messages; a malformed one is ignored."""
        self._simulated = decode_clock(payloads[-1]) or self._simulated
