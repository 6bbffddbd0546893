from __future__ import annotations

import time

from rostether.graph.ros_clock import decode_clock, encode_clock, wall_time
from rostether.rostime import Time


def test_a_clock_message_is_a_time() -> None:
    assert encode_clock(Time(1, 2)) == bytes.fromhex("0100000002000000")
    assert decode_clock(bytes.fromhex("0100000002000000")) == Time(1, 2)
    assert decode_clock(bytes(7)) is None


def test_the_wall_clock_is_that_of_this_machine() -> None:
    before_ns = time.time_ns()
    assert before_ns <= wall_time().to_ns() <= time.time_ns()
