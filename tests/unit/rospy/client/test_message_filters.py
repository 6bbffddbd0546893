from __future__ import annotations

from types import SimpleNamespace

import pytest

from rostether.rospy.client import message_filters
from rostether.rospy.client.message_filters import (
    ApproximateTimeSynchronizer,
    SimpleFilter,
    TimeSynchronizer,
)
from rostether.rospy.client.ros_time import Time


def stamped(seconds: float) -> SimpleNamespace:
    return SimpleNamespace(header=SimpleNamespace(stamp=Time(seconds)))


@pytest.mark.parametrize(
    ("reset", "is_wallclock", "count"), [(True, False, 1), (False, False, 0), (True, True, 0)]
)
def test_a_jump_back_of_simulated_time_clears_the_queues_with_reset(
    monkeypatch: pytest.MonkeyPatch, reset: bool, is_wallclock: bool, count: int
) -> None:
    now = Time(100)
    monkeypatch.setattr(message_filters, "is_wallclock", lambda: is_wallclock)
    monkeypatch.setattr(message_filters, "get_rostime", lambda: now)
    first, second = SimpleFilter(), SimpleFilter()
    together: list[object] = []
    TimeSynchronizer([first, second], 1, reset).registerCallback(lambda *messages: together.append(messages))
    first.signalMessage(stamped(100))
    now = Time(1)
    for each in (first, second):
        each.signalMessage(stamped(1))
    assert len(together) == count


def test_near_messages_are_combined_even_if_the_nearest_ones_do_not_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(message_filters, "get_rostime", lambda: Time(1))
    sources = [SimpleFilter() for _ in range(3)]
    together: list[list[float]] = []
    synchronizer = ApproximateTimeSynchronizer(sources, 5, 0.1)
    synchronizer.registerCallback(
        lambda *messages: together.append([each.header.stamp.to_sec() for each in messages])
    )
    for index, seconds in ((1, 0.94), (1, 1.07), (2, 1.05), (0, 1.0)):
        sources[index].signalMessage(stamped(seconds))
    assert together == [pytest.approx([1.0, 1.07, 1.05])]


def test_filters_can_be_created_before_the_node() -> None:
    assert ApproximateTimeSynchronizer([SimpleFilter()], 1, 0.1).slop.to_sec() == pytest.approx(0.1)
