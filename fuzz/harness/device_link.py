"""The device's half of a line, against whatever a host may say."""

from __future__ import annotations

import contextlib

from fuzz.harness.link_script import step, steps
from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import MAX_WAITING_BYTES, DeviceLink
from rostether.rosserial.packets import LogLevel, ParameterResponse

MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"


def seeds() -> list[bytes]:
    """Return what a host says to a device."""
    ask = step(ids.PUBLISHER, b"")
    time = step(ids.TIME, bytes(8))
    answer = step(ids.PARAMETER, ParameterResponse((1,), (), ()).encode())
    return [ask + time, ask + time + answer + step(100, b"\1\0\0\0a"), step(0, b"\xff\x00", kind=6) + ask]


def run(data: bytes) -> None:
    """Play a script to a device that publishes and asks all the time."""
    link, now_s = DeviceLink(), 0.0
    topic = link.add_publisher("chatter", "std_msgs/String", MD5SUM)
    link.add_subscriber("led", "std_msgs/String", MD5SUM)
    link.start(now_s)
    for received, pause_s in steps(data):
        now_s += pause_s
        link.handle_timer(now_s)
        link.receive_data(received, now_s)
        link.publish(topic, [b"\1\0\0\0a"])
        link.log(LogLevel.INFO, "x")
        with contextlib.suppress(LocalProtocolError):  # no more may wait
            link.request_parameter("~gains", now_s)
        link.time(now_s)
        assert len(link.data_to_send()) <= 2 * MAX_WAITING_BYTES
