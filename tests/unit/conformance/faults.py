"""Faults of clients, planted between a correct client and its line; each is a mistake of a real client."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable
from dataclasses import dataclass

from msgspec.structs import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.frame_decoder import FrameDecoder, Frames
from rostether.rosserial.packets import ParameterResponse, TopicInfo, decode_time, encode_time
from rostether.rostime import Time
from rostether.transports.memory import Direction, Manipulator

# Returns the bytes that replace a frame.
Change = Callable[[int, bytes], bytes]
STOP, PROBE = encode_frame(ids.TX_STOP, b""), b"\xff\x00"


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault, how to add it, and the case that must find it."""

    name: str
    found_by: str
    plant: Callable[[], Manipulator]


def sent(change: Change) -> Callable[[], Manipulator]:
    """Add a fault to the frames that the client sends."""

    def plant() -> Manipulator:
        decoder = FrameDecoder()

        def manipulate(data: bytes, direction: Direction) -> bytes:
            if direction is Direction.FIRST_TO_SECOND:
                return data
            frames = (each for each in decoder.feed(data, 0.0) if isinstance(each, Frames))
            return b"".join(change(each.topic_id, payload) for each in frames for payload in each.payloads)

        return manipulate

    return plant


def received(change: Callable[[bytes], bytes]) -> Callable[[], Manipulator]:
    """Add a fault to the bytes that the client receives."""

    def manipulate(data: bytes, direction: Direction) -> bytes:
        return change(data) if direction is Direction.FIRST_TO_SECOND else data

    return lambda: manipulate


def received_frames(change: Change) -> Callable[[], Manipulator]:
    """Add a fault to a frame that the client receives alone."""

    def take(data: bytes) -> bytes:
        if len(data) < 8 or data[:2] != b"\xff\xfe" or len(data) != 8 + int.from_bytes(data[2:4], "little"):
            return data
        return change(int.from_bytes(data[5:7], "little"), data[7:-1])

    return received(take)


def announced(change: Callable[[TopicInfo], TopicInfo]) -> Callable[[], Manipulator]:
    """Add a fault to the announcements."""

    def announce(topic_id: int, payload: bytes) -> bytes:
        info = TopicInfo.decode(payload) if topic_id in ids.ANNOUNCEMENTS else None
        return encode_frame(topic_id, payload if info is None else change(info).encode())

    return sent(announce)


def _zero_md5sum(info: TopicInfo) -> TopicInfo:
    return replace(info, md5sum="0" * 32) if info.message_type == "std_msgs/Time" else info


def _one_id(info: TopicInfo) -> TopicInfo:
    return replace(info, topic_id=126) if info.topic_name.endswith("pong") else info


def _with_zero_byte(topic_id: int, payload: bytes) -> bytes:
    return encode_frame(topic_id, payload + b"\x00" if topic_id == ids.SUBSCRIBER else payload)


def _without_time(topic_id: int, payload: bytes) -> bytes:
    return b"" if topic_id == ids.TIME else encode_frame(topic_id, payload)


def _one_level_up(topic_id: int, payload: bytes) -> bytes:
    is_log = topic_id == ids.LOG
    return encode_frame(topic_id, bytes((payload[0] + 1,)) + payload[1:] if is_log else payload)


def _short_doubles(topic_id: int, payload: bytes) -> bytes:
    if topic_id == 126:
        payload = struct.pack("<f", *struct.unpack("<d", payload))
    return encode_frame(topic_id, payload)


def _with_prints(topic_id: int, payload: bytes) -> bytes:
    return (b"debug: 3\r\n" if topic_id == ids.LOG else b"") + encode_frame(topic_id, payload)


def _unchecked(data: bytes) -> bytes:
    if data.startswith(b"\xff\xfe") and len(data) > 8:
        size = int.from_bytes(data[2:4], "little")
        if len(data) >= 8 + size:
            return encode_frame(int.from_bytes(data[5:7], "little"), data[7 : 7 + size]) + data[8 + size :]
    return data


def _short_buffer(topic_id: int, payload: bytes) -> bytes:
    return encode_frame(topic_id, payload) if len(payload) <= 128 else b""


def _ahead(topic_id: int, payload: bytes) -> bytes:
    time = decode_time(payload) if topic_id == ids.TIME else None
    return encode_frame(topic_id, payload if time is None else encode_time(Time(time.secs + 60, time.nsecs)))


def _without_nanoseconds(topic_id: int, payload: bytes) -> bytes:
    # The program's only message of 8 bytes with such an id is the client's clock.
    time = decode_time(payload) if topic_id == 127 else None
    return encode_frame(
        topic_id, payload if time is None else encode_time(Time(time.secs, time.nsecs // 1000))
    )


def _cut_first(data: bytes) -> bytes:
    # The first of two frames is a string with one byte too many.
    size = int.from_bytes(data[2:4], "little")
    if (
        data.startswith(b"\xff\xfe")
        and len(data) > 8 + size
        and size == 5 + int.from_bytes(data[7:11], "little")
    ):
        return encode_frame(int.from_bytes(data[5:7], "little"), data[7 : 6 + size]) + data[8 + size :]
    return data


def _slow_time() -> Manipulator:
    requests = itertools.count()

    def every_third(topic_id: int, payload: bytes) -> bytes:
        return b"" if topic_id == ids.TIME and next(requests) % 3 else encode_frame(topic_id, payload)

    return sent(every_third)()


def _checks_seven_bits(data: bytes) -> bytes:
    if len(data) > 8 and data.startswith(b"\xff\xfe"):
        end = 8 + int.from_bytes(data[2:4], "little")
        if sum(data[5:end]) % 256 == 0x7F:
            return encode_frame(int.from_bytes(data[5:7], "little"), data[7 : end - 1]) + data[end:]
    return data


def _reversed_ints(topic_id: int, payload: bytes) -> bytes:
    response = ParameterResponse.decode(payload) if topic_id == ids.PARAMETER else None
    if response is not None:
        payload = ParameterResponse(response.ints[::-1], response.floats, response.strings).encode()
    return encode_frame(topic_id, payload)


def _time_ends_calls(topic_id: int, payload: bytes) -> bytes:
    # The response id of the program's service client; without a call, the client ignores a response.
    ending = encode_frame(105, b"\x00" + bytes(4)) if topic_id == ids.TIME else b""
    return encode_frame(topic_id, payload) + ending


def _forgetful() -> Manipulator:
    seen: set[bytes] = set()

    def announce_once(topic_id: int, payload: bytes) -> bytes:
        is_known = topic_id == ids.SUBSCRIBER and payload in seen
        seen.add(payload)
        return b"" if is_known else encode_frame(topic_id, payload)

    return sent(announce_once)()


def _silent_later() -> Manipulator:
    requests = itertools.count()

    def answer_once(topic_id: int, payload: bytes) -> bytes:
        return b"" if topic_id == ids.TOPIC_REQUEST and next(requests) else encode_frame(topic_id, payload)

    return received_frames(answer_once)()


def _patient() -> Manipulator:
    waiting = bytearray()

    def take(data: bytes) -> bytes:
        waiting.extend(data)
        if waiting[:1] == b"\xff" and (len(waiting) < 5 or _is_incomplete(waiting)):
            return b""
        whole = bytes(waiting)
        waiting.clear()
        return whole

    return received(take)()


def _is_incomplete(data: bytearray) -> bool:
    has_header = data[1] == 0xFE and sum(data[2:5]) % 256 == 0xFF
    return has_header and len(data) < 8 + int.from_bytes(data[2:4], "little")


FAULTS = (
    Fault("a wrong md5sum", "announce-md5sums", announced(_zero_md5sum)),
    Fault("one id for two topics", "announce-ids", announced(_one_id)),
    Fault("announcements with a byte too many", "announce-layout", sent(_with_zero_byte)),
    Fault("subscribers announced only once", "announce-again", _forgetful),
    Fault("only the first request answered", "announce-again", _silent_later),
    Fault("torn frames never dropped", "frame-torn", _patient),
    Fault("no time request", "time-period", sent(_without_time)),
    Fault("log levels from 1", "log-levels", sent(_one_level_up)),
    Fault("doubles of 4 bytes", "message-real", sent(_short_doubles)),
    Fault("prints between the frames", "frame-sent", sent(_with_prints)),
    Fault("payloads not checked", "frame-check", received(_unchecked)),
    Fault("frames only whole", "frame-split", received(lambda data: data if len(data) > 1 else b"")),
    Fault("a buffer smaller than announced", "frame-longest", received_frames(_short_buffer)),
    Fault("the stop request ignored", "stop-silent", received(lambda data: b"" if data == STOP else data)),
    Fault("probes ignored", "probe-waiting", received(lambda data: b"" if data == PROBE else data)),
    Fault("a clock 60 s ahead", "time-clock", received_frames(_ahead)),
    Fault("nanoseconds divided by 1000", "time-advance", sent(_without_nanoseconds)),
    Fault("the time requested too rarely", "time-period", _slow_time),
    Fault("a checksum of seven bits", "frame-check", received(_checks_seven_bits)),
    Fault("bytes after a message ignored", "message-long", received(_cut_first)),
    Fault("parameters in reverse", "parameter-ints", received_frames(_reversed_ints)),
    Fault("a time ends a call", "service-call-time", received_frames(_time_ends_calls)),
)
