from __future__ import annotations

from rostether.rosserial import topic_id as ids
from rostether.rosserial.host_output import MAX_WAITING_BYTES, PROBE, HostOutput
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.rosserial.packets import ParameterResponse
from rostether.rosserial.topic_table import TopicTable
from rostether.rostime import Time
from unit.rosserial.decoding import frame


def output(version: int | None = 2) -> HostOutput:
    one = HostOutput(TopicTable(10), LinkStatistics())
    one.version = version
    return one


def test_only_a_guess_of_version_1_is_guarded() -> None:
    one = output(None)
    request = frame(ids.TOPIC_REQUEST, b"", 1)
    one.queue_topic_request(1, 0.0, is_guess=True)
    assert one.pop_ready() == b"\0" + request + b"\0"
    one.queue_topic_request(1, 0.0, is_guess=False)
    assert one.pop_ready() == request
    one.queue_topic_request(2, 0.0, is_guess=True)
    assert one.pop_ready() == frame(ids.TOPIC_REQUEST, b"")


def test_probes_are_for_version_2() -> None:
    for version, expected in ((None, b""), (1, b""), (2, PROBE)):
        one = output(version)
        one.queue_probe()
        assert one.pop_ready() == expected


def test_a_time_answer_that_waits_is_replaced_by_the_next() -> None:
    one = output()
    one.call_started()
    one.queue_time(Time(1, 0), 0.0)
    one.queue_time(Time(4, 0), 3.0)
    one.call_finished(3.5)
    assert one.pop_ready() == frame(ids.TIME, b"\x04\0\0\0\x00\x65\xcd\x1d")


def test_a_reset_releases_the_frames_that_a_call_held() -> None:
    one = output()
    one.call_started()
    one.queue_topic_request(2, 0.0, is_guess=False)
    assert one.pop_ready() == b""
    one.device_reset()
    one.pump(0.1)
    assert one.pop_ready() == frame(ids.TOPIC_REQUEST, b"")


def test_unread_frames_do_not_fill_memory() -> None:
    one = output()
    for _ in range(10000):
        one.queue_parameter(ParameterResponse())
    assert len(one.pop_ready()) <= MAX_WAITING_BYTES


def test_stop_sends_nothing_else() -> None:
    one = output()
    one.call_started()
    one.queue_time(Time(1, 0), 0.0)
    one.queue_probe()
    one.queue_stop()
    assert one.pop_ready() == frame(ids.TX_STOP, b"")
    assert one.get_timer() is None
