"""Every recorded session, as text for users."""

from __future__ import annotations

from collections import Counter

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.line_log import LineEntry, LineLog, version_of
from rostether.rosserial.packets import Log, LogLevel, ParameterRequest, TopicInfo
from unit.rosserial.decoding import plain_decode
from vectors.captures import Capture, frame_counts, load, names

COUNTS = frame_counts()


def read(capture: Capture) -> list[LineEntry]:
    log = LineLog(capture.version)
    entries = [
        entry for chunk in capture.chunks for entry in log.feed(chunk.time_s, chunk.from_device, chunk.data)
    ]
    return entries + list(log.finish(capture.seconds))


@pytest.mark.parametrize("name", names())
def test_frames_in_order(name: str) -> None:
    capture = load(name)
    entries = read(capture)
    frames = [entry for entry in entries if not entry.fault]
    assert sum(entry.from_device for entry in frames) == COUNTS[name][0]
    assert sum(not entry.from_device for entry in frames) == COUNTS[name][1]
    line = b"".join(chunk.data for chunk in capture.of_device())
    assert [(entry.topic_id, entry.data) for entry in frames if entry.from_device] == list(
        plain_decode(line, capture.version)
    )


@pytest.mark.parametrize("name", names())
def test_no_byte_is_skipped(name: str) -> None:
    capture = load(name)
    overhead_bytes = 8 if capture.version == 2 else 7
    reported = sum(
        len(entry.data) + (0 if entry.fault else overhead_bytes)
        for entry in read(capture)
        if entry.from_device
    )
    assert reported == sum(len(chunk.data) for chunk in capture.of_device())


@pytest.mark.parametrize("name", names())
def test_topics_have_their_names(name: str) -> None:
    capture = load(name)
    entries = read(capture)
    whats = Counter(entry.what for entry in entries if (entry.topic_id or 0) >= ids.FIRST_USER_ID)
    known = {topic.name for topic in capture.topics.values()} | {"a topic that was not announced"}
    assert set(whats) <= known
    if name not in ("damaged", "damaged_announce"):
        assert whats["a topic that was not announced"] == 0


@pytest.mark.parametrize("name", names())
def test_the_version_is_seen(name: str) -> None:
    capture = load(name)
    assert version_of(b"".join(chunk.data for chunk in capture.of_device())) == capture.version


def test_the_default_version_is_2() -> None:
    assert version_of(b"") == 2


def test_control_frames_in_words() -> None:
    log = LineLog()

    def says(frame: bytes, *, from_device: bool) -> str:
        (entry,) = log.feed(0.0, from_device, frame)
        return entry.what

    assert says(encode_frame(ids.TOPIC_REQUEST, b""), from_device=False) == "requests the topics"
    assert says(encode_frame(ids.TX_STOP, b""), from_device=False) == "requests a stop"
    assert says(encode_frame(ids.TIME, bytes(8)), from_device=True) == "requests the time"
    assert says(encode_frame(ids.TIME, bytes(8)), from_device=False) == "answers with the time"
    logged = encode_frame(ids.LOG, Log(LogLevel.WARN, "hot\x1b[2J").encode())
    assert says(logged, from_device=True) == "logs WARN 'hot\\x1b[2J'"
    assert says(encode_frame(ids.LOG, b"\1\2"), from_device=True) == "an invalid log line"
    asked = encode_frame(ids.PARAMETER, ParameterRequest("~gain").encode())
    assert says(asked, from_device=True) == "requests parameter ~gain"
    assert says(encode_frame(ids.PARAMETER, b"\1"), from_device=True) == "an invalid request"
    assert says(encode_frame(ids.PARAMETER, bytes(12)), from_device=False) == "answers with a parameter"
    assert says(encode_frame(ids.PUBLISHER, b"\1"), from_device=True) == "an invalid announcement"
    hostile = TopicInfo(125, "a", "\x1b[2J", "\x07", 512).encode()
    assert says(encode_frame(ids.PUBLISHER, hostile), from_device=True).isprintable()
    assert says(encode_frame(300, b"\1"), from_device=True) == "a topic that was not announced"


def test_text_between_frames_is_one_entry() -> None:
    log = LineLog()
    frame = encode_frame(ids.TIME, bytes(8))
    entries = list(log.feed(0.0, True, b"Temperature: 21.5 C\r\n" + frame))
    assert [(entry.data, bool(entry.fault)) for entry in entries] == [
        (b"Temperature: 21.5 C\r\n", True),
        (bytes(8), False),
    ]
