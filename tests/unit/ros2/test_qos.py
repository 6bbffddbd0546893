from __future__ import annotations

from rostether.ros2.qos import DEFAULT_QOS, LATCHED_QOS


def test_only_transient_local_is_latching() -> None:
    assert LATCHED_QOS.is_latching
    assert not DEFAULT_QOS.is_latching
