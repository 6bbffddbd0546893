from __future__ import annotations

from rostether.ros2.qos import DEFAULT_QOS, LATCHED_QOS, SENSOR_DATA_QOS, explain_mismatch


def test_ends_that_promise_enough_meet() -> None:
    assert explain_mismatch(DEFAULT_QOS, DEFAULT_QOS) == ""
    assert explain_mismatch(DEFAULT_QOS, SENSOR_DATA_QOS) == ""
    assert explain_mismatch(LATCHED_QOS, DEFAULT_QOS) == ""


def test_ends_that_promise_too_little_are_explained() -> None:
    assert "best effort" in explain_mismatch(SENSOR_DATA_QOS, DEFAULT_QOS)
    assert "transient local" in explain_mismatch(DEFAULT_QOS, LATCHED_QOS)
    both = explain_mismatch(SENSOR_DATA_QOS, LATCHED_QOS)
    assert "best effort" in both
    assert "transient local" in both


def test_only_transient_local_latches() -> None:
    assert LATCHED_QOS.is_latching
    assert not DEFAULT_QOS.is_latching
