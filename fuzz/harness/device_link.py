"""The link of a device, with any data from a host."""

from __future__ import annotations

import contextlib
import random
import struct

from fuzz.grammar import near
from fuzz.harness.link_script import MAX_BODY_BYTES, burst, random_step, step, steps
from fuzz.lowering import lowered
from rostether.errors import LocalProtocolError
from rostether.rosserial import device_link
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.device_parameters import MAX_REQUESTS
from rostether.rosserial.events import MessagesReceived, ParameterReceived, ParameterTimedOut, TimeAnswered
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import LogLevel, ParameterResponse

MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"
MAX_WAITING_BYTES = 512
MAX_INPUT_BYTES = 64
_MESSAGE = b"\1\0\0\0a"
_MESSAGE_FRAME_BYTES = len(encode_frame(125, _MESSAGE))


def seeds() -> list[bytes]:
    """Return data that a host sends to a device."""
    ask = step(ids.PUBLISHER, b"")
    time = step(ids.TIME, bytes(8))
    answer = step(ids.PARAMETER, ParameterResponse((1,), (), ()).encode())
    return [ask + time, ask + time + answer + step(100, b"\1\0\0\0a"), step(0, b"\xff\x00", kind=6) + ask]


def generate(source: random.Random) -> bytes:
    """Return the data of a host that requests the topics, then sends valid, invalid and too large data."""
    script = step(ids.TOPIC_REQUEST, b"")
    for _ in range(source.randint(1, 30)):
        match source.randrange(7):
            case 0:
                body = struct.pack("<II", 1, near(source, 10**9) % 2**32)
                script += random_step(source, ids.TIME, body[: source.choice((8, 8, 4, 0))])
            case 1:
                values = tuple(range(source.randint(0, 3)))
                script += random_step(source, ids.PARAMETER, ParameterResponse(values).encode())
            case 2:
                size = min(near(source, MAX_INPUT_BYTES), MAX_BODY_BYTES)
                script += step(source.choice((100, 101, 125)), bytes(size))
            case 3:
                script += burst(source, source.choice((ids.TIME, 100)), bytes(8))
            case 4:
                script += random_step(source, source.choice((0, ids.TX_STOP, 200)), b"")
            case _:
                script += step(0, b"", kind=source.choice((0, 8, 8, 8, 2, 4, 6)))
    return script


def run(data: bytes) -> None:
    """Feed a script to a device that publishes and requests parameters all the time."""
    with lowered(device_link, MAX_WAITING_BYTES=MAX_WAITING_BYTES):
        _play(data)


def _play(data: bytes) -> None:
    link, now_s = DeviceLink(DeviceLinkConfig(input_buffer_bytes=MAX_INPUT_BYTES)), 0.0
    topic = link.add_publisher("chatter", "std_msgs/String", MD5SUM)
    listens_on = link.add_subscriber("led", "std_msgs/String", MD5SUM)
    link.start(now_s)
    asked = published_bytes = 0
    for received, pause_s, is_taken in steps(data):
        now_s += pause_s
        for event in [*link.handle_timer(now_s), *link.receive_data(received, now_s)]:
            match event:
                case MessagesReceived(topic_id, payloads):
                    assert topic_id == listens_on, "a message without a subscriber"
                    assert max(map(len, payloads)) <= MAX_INPUT_BYTES, "a message larger than the buffer"
                case ParameterReceived() | ParameterTimedOut():
                    asked -= 1
                case TimeAnswered():
                    assert event.time.nsecs < 10**9
        for _ in range(8):
            published_bytes += _MESSAGE_FRAME_BYTES * link.publish(topic, [_MESSAGE])
        link.log(LogLevel.INFO, "x")
        with contextlib.suppress(LocalProtocolError):  # more may not be queued
            link.request_parameter("~gains", now_s)
            asked += 1
        assert asked <= MAX_REQUESTS, "more requests wait than allowed"
        assert published_bytes <= MAX_WAITING_BYTES + _MESSAGE_FRAME_BYTES, "more bytes wait than allowed"
        link.time(now_s)
        if is_taken:
            link.data_to_send()
            published_bytes = 0
