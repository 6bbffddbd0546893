"""ROS time."""

from __future__ import annotations

import struct

from rostether.ros1.node.clock import Clock
from rostether.rostime import Time


def test_the_wall_clock_unless_simulated() -> None:
    clock = Clock(lambda: Time(12, 34))
    assert clock.now() == Time(12, 34)
    clock.simulate()
    assert clock.now() == Time(0, 0)
    clock.handle_messages([struct.pack("<II", 1, 2), struct.pack("<II", 3, 4)])
    assert clock.now() == Time(3, 4)


def test_a_malformed_tick_is_ignored() -> None:
    clock = Clock()
    clock.simulate()
    clock.handle_messages([struct.pack("<II", 3, 4)])
    clock.handle_messages([b""])
    clock.handle_messages([bytes(9)])
    assert clock.now() == Time(3, 4)
