from __future__ import annotations

import random

import pytest

from rostether.errors import LocalProtocolError
from rostether.rosserial.frame import FORMS, encode_frame, encode_frames, read_header
from unit.rosserial.decoding import frame

KNOWN = [
    (2, 0, b"", "fffe0000ff0000ff"),
    (2, 125, b"\x0c\0\0\0hello world!", "fffe1000ef7d000c00000068656c6c6f20776f726c6421f9"),
    (2, 10, bytes(8), "fffe0800f70a000000000000000000f5"),
    (1, 0, b"", "ffff00000000ff"),
    (1, 125, b"\x0c\0\0\0hello world!", "ffff7d0010000c00000068656c6c6f20776f726c6421e9"),
    (1, 10, bytes(8), "ffff0a0008000000000000000000ed"),
]


@pytest.mark.parametrize(("version", "topic_id", "payload", "line"), KNOWN)
def test_recorded_frames(version: int, topic_id: int, payload: bytes, line: str) -> None:
    assert encode_frame(topic_id, payload, version).hex() == line


@pytest.mark.parametrize("version", FORMS)
@pytest.mark.parametrize("size", [0, 1, 255, 256, 257, 512, 513, 65535])
def test_every_size(version: int, size: int) -> None:
    payload = random.Random(size).randbytes(size)
    assert encode_frame(0xABCD, payload, version) == frame(0xABCD, payload, version)


@pytest.mark.parametrize("version", FORMS)
def test_batch_equals_frames_one_by_one(version: int) -> None:
    payloads = [bytes(range(size)) for size in (0, 3, 3, 250)]
    assert encode_frames(101, payloads, version) == b"".join(frame(101, p, version) for p in payloads)


@pytest.mark.parametrize("version", FORMS)
def test_header_is_read_back(version: int) -> None:
    header = read_header(version, encode_frame(300, bytes(1000), version)[: FORMS[version].header_bytes])
    assert header is not None
    assert (header.topic_id, header.size) == (300, 1000)


def test_header_with_wrong_length_check_is_not_read() -> None:
    assert read_header(2, bytes.fromhex("fffe1000ee7d00")) is None


@pytest.mark.parametrize(
    ("topic_id", "size", "version", "what"),
    [(-1, 0, 2, "topic id"), (65536, 0, 2, "topic id"), (1, 65536, 2, "65535"), (1, 0, 3, "version 3")],
)
def test_contents_that_no_frame_can_hold(topic_id: int, size: int, version: int, what: str) -> None:
    with pytest.raises(LocalProtocolError, match=what):
        encode_frame(topic_id, bytes(size), version)
