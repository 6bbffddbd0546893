from __future__ import annotations

from rostether.recording.time_order import TimeOrder
from rostether.rostime import NS_PER_S


def _fault(*seconds: float) -> str:
    order = TimeOrder()
    for each in seconds:
        order.add(round(each * NS_PER_S))
    return order.fault


def test_small_steps_back_are_not_a_fault() -> None:
    assert not _fault()
    assert not _fault(1, 1, 2, 1.5, 3)


def test_jumps_back_are_counted_and_the_first_is_shown() -> None:
    assert "goes back once from 90.00 s to 1.50 s, for instance because a simulation was reset" in _fault(
        80, 90, 1.5, 2
    )
    assert "goes back 2 times, first from 9.00 s to 0.00 s" in _fault(9, 0, 8, 2)
    assert "`rostether bag filter FILE NEW_FILE True` sorts the messages" in _fault(9, 0)
