"""The statistics of rostopic."""

from __future__ import annotations

import pytest

from rostether.rospy.client.ros_time import Time
from rostether.rospy.tools import topic_statistics
from rostether.rospy.tools.topic_statistics import ROSTopicBandwidth, ROSTopicHz


class _AnyMessage:
    _buff = b"12345"


def test_rates_of_topics(capsys: pytest.CaptureFixture[str]) -> None:
    rates = ROSTopicHz(-1, filter_expr=lambda message: message != "ignored", use_wtime=True)
    rates.print_hz()
    for message in ("first", "ignored", "second", "third"):
        rates.callback_hz(message, "/scan")
    assert len(rates.get_times("/scan")) == 2
    found = rates.get_hz("/scan")
    assert found is not None
    assert found[1] <= found[2]
    assert found[4] == 3
    assert rates.get_hz("/scan") is None
    rates.callback_hz("fourth", "/scan")
    rates.callback_hz("only one", "/odom")
    rates.print_hz(("/scan", "/odom"))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "no new messages"
    assert lines[1].split() == ["topic", "rate", "min_delta", "max_delta", "std_dev", "window"]
    assert [line.split()[0] for line in lines[3:] if line] == ["/scan"]


def test_window_of_one_message_has_no_interval() -> None:
    rates = ROSTopicHz(0, use_wtime=True)
    rates.callback_hz("first")
    rates.callback_hz("second")
    assert rates.times == []
    assert rates.get_hz() is None


def test_rate_starts_again_when_simulated_time_is_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    rates = ROSTopicHz(-1)
    for now in (Time(0), Time(4), Time(5), Time(0)):
        monkeypatch.setattr(topic_statistics, "get_rostime", lambda now=now: now)
        rates.callback_hz("message")
    assert rates.times == []
    assert rates.get_hz() is None
    for now in (Time(6), Time(8)):
        monkeypatch.setattr(topic_statistics, "get_rostime", lambda now=now: now)
        rates.callback_hz("message")
    assert rates.times == [2.0]


def test_bandwidth(capsys: pytest.CaptureFixture[str]) -> None:
    bandwidth = ROSTopicBandwidth(window_size=2)
    bandwidth.callback(_AnyMessage())
    bandwidth.print_bw()
    assert capsys.readouterr().out == ""
    bandwidth.callback(_AnyMessage())
    bandwidth.callback(_AnyMessage())
    bandwidth.print_bw()
    assert " window: 2" in capsys.readouterr().out
    assert bandwidth.sizes == [5, 5]
    assert len(bandwidth.times) == 2
