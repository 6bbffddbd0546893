"""ROS time: the wall clock, or under /use_sim_time the messages of /clock."""

from __future__ import annotations

import struct
import time

from rostether.msgdef.interface import MessageType
from rostether.rostime import Time

CLOCK_TOPIC = "/clock"
CLOCK_TYPE = MessageType("rosgraph_msgs/Clock", "a9c97c1d230cfc112e270351a944ee47", "time clock\n")

_CLOCK = struct.Struct("<II")


def wall_time() -> Time:
    """Return the time of this machine's clock."""
    return Time.from_ns(time.time_ns())


def encode_clock(now: Time) -> bytes:
    """Return a time as a serialized rosgraph_msgs/Clock."""
    return _CLOCK.pack(*now)


def decode_clock(payload: bytes) -> Time | None:
    """Return the time of a serialized rosgraph_msgs/Clock, None if it is malformed."""
    return Time(*_CLOCK.unpack(payload)) if len(payload) == _CLOCK.size else None
