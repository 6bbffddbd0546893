"""The packets of the protocol: a decoded packet can be encoded again, and contains all bytes."""

from __future__ import annotations

import random
import struct

from fuzz.grammar import name, near, string
from rostether.errors import RostetherError
from rostether.rosserial.packets import (
    MAX_BUFFER_BYTES,
    MAX_NAME_BYTES,
    Log,
    LogLevel,
    ParameterRequest,
    ParameterResponse,
    TopicInfo,
    decode_time,
    encode_time,
)
from rostether.rostime import Time

MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"
_DECODERS = (TopicInfo.decode, Log.decode, ParameterRequest.decode, ParameterResponse.decode)


def seeds() -> list[bytes]:
    """Return one packet of each kind."""
    return [
        TopicInfo(125, "chatter", "std_msgs/String", MD5SUM, 512).encode(),
        Log(LogLevel.WARN, "a line").encode(),
        ParameterRequest("~gains").encode(),
        ParameterResponse((1, -2), (0.5,), ("a", "")).encode(),
        encode_time(Time(1, 2)),
    ]


def generate(source: random.Random) -> bytes:
    """Return a packet of one kind, sometimes with one invalid field or an extra byte."""
    kind = source.randrange(5)
    if kind == 0:
        texts = (name(source), source.choice(("std_msgs/String", "String", "a/b/c")), MD5SUM)
        if source.random() < 0.2:
            texts = (*texts[:2], source.choice(("", MD5SUM.upper(), MD5SUM[:-1], "*")))
        size = source.choice((0, 512, -1, -(2**31), MAX_BUFFER_BYTES, MAX_BUFFER_BYTES + 1))
        topic_id = struct.pack("<H", source.choice((125, 100, 101, 65535, 0, near(source, 100) % 65536)))
        data = topic_id + b"".join(string(text.encode()) for text in texts) + struct.pack("<i", size)
    elif kind == 1:
        data = source.randbytes(1) + string(source.randbytes(source.randint(0, 40)))
    elif kind == 2:
        data = string(name(source).encode())
    elif kind == 3:
        counts = [source.randint(0, 3) for _ in range(3)]
        data = b"".join(struct.pack("<I", count) + source.randbytes(4 * count) for count in counts[:2])
        data += struct.pack("<I", counts[2]) + b"".join(string(b"ab") for _ in range(counts[2]))
    else:
        data = struct.pack("<II", near(source, 5), near(source, 10**9) % 2**32)
    chance = source.random()
    return data + b"\0" if chance < 0.1 else data[:-1] if chance < 0.2 else data


def run(data: bytes) -> None:
    """Decode the data as each kind of packet."""
    for decode in _DECODERS:
        packet = decode(data)
        if packet is not None:
            try:
                again = decode(packet.encode())
            except RostetherError:
                continue
            # NaN is not equal to anything.
            assert repr(again) == repr(packet)
    info = TopicInfo.read(data)
    assert (info is not None) == _has_layout(data, "HSSSi", MAX_NAME_BYTES)
    if info is not None:
        fault = info.fault()
        assert fault is None or "\n" not in fault
        if fault is None:
            assert 100 <= info.topic_id <= 65535
            assert 0 <= info.buffer_size <= MAX_BUFFER_BYTES
            assert len(info.md5sum) == 32
            assert info.message_type.count("/") == 1
    assert (Log.decode(data) is not None) == _has_layout(data, "BS", len(data))
    if ParameterRequest.decode(data) is not None:
        assert _has_layout(data, "S", MAX_NAME_BYTES)
    if ParameterResponse.decode(data) is not None:
        assert _has_layout(data, "445", len(data))
    time = decode_time(data)
    assert (time is not None) == (len(data) == 8 and int.from_bytes(data[4:8], "little") < 10**9)


def _has_layout(data: bytes, fields: str, most_bytes: int) -> bool:
    """Return whether the data has exactly these fields: numbers as in `struct`, S a string, 4 and 5 lists."""
    place = 0
    for field in fields:
        if field in "HBi":
            place += struct.calcsize(f"<{field}")
            continue
        count = int.from_bytes(data[place : place + 4], "little")
        place += 4
        if field == "S":
            if count > most_bytes:
                return False
            place += count
        elif field == "4":
            place += 4 * count
        else:
            for _ in range(count):
                if place > len(data):
                    return False
                place += 4 + int.from_bytes(data[place : place + 4], "little")
        if place > len(data):
            return False
    return place == len(data)
