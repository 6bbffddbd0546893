from __future__ import annotations

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import DiscardReason, FrameDiscarded
from rostether.rosserial.frame_decoder import Frames, PayloadLimits
from rostether.rosserial.packets import Log, LogLevel, TopicInfo
from rostether.rosserial.protocol_detector import HOLD_NOISE_S, MAX_HELD, ProtocolDetector
from rostether.rosserial.topic_table import CONTROL_LIMITS
from unit.rosserial.decoding import by_topic, frame
from unit.rosserial.sessions import STRING, STRING_MD5

PACKETS = {
    ids.TIME: bytes(8),
    ids.LOG: Log(LogLevel.INFO, "setup").encode(),
    ids.PARAMETER: b"\x05\0\0\0~rate",
    ids.PUBLISHER: TopicInfo(125, "chatter", STRING, STRING_MD5, 280).encode(),
}


def detector() -> ProtocolDetector:
    return ProtocolDetector(max_payload_bytes=65535, limits=PayloadLimits(CONTROL_LIMITS))


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("topic_id", PACKETS)
def test_a_control_packet_shows_the_version(version: int, topic_id: int) -> None:
    for size in (1, 1000):
        one = detector()
        data = frame(topic_id, PACKETS[topic_id], version)
        found = [item for at in range(0, len(data), size) for item in one.feed(data[at : at + size], 0.0)]
        assert one.decoder is not None
        assert one.decoder.version == version
        assert found == [Frames(topic_id, [PACKETS[topic_id]])]


def test_a_message_proves_version_2_but_not_version_1() -> None:
    one = detector()
    assert one.feed(frame(125, b"hello", 1), 0.0) == []
    assert one.decoder is None
    assert by_topic(one.feed(frame(125, b"hello"), 0.0)) == {125: [b"hello"]}
    assert one.decoder is not None


def test_an_empty_time_request_proves_version_2() -> None:
    assert detector().feed(frame(ids.TIME, b"", 1), 0.0) == []
    assert detector().feed(frame(ids.TIME, b""), 0.0) == [Frames(ids.TIME, [b""])]


@pytest.mark.parametrize("payload", [bytes(7), bytes(9)])
def test_damage_is_ignored(payload: bytes) -> None:
    for version in (1, 2):
        one = detector()
        one.feed(frame(ids.TIME, payload, version), 0.0)
        assert one.decoder is None


def test_noise_before_the_first_frame_is_reported_with_it() -> None:
    one = detector()
    assert one.feed(b"boot\r\n", 0.0) == []
    assert one.feed(frame(ids.TIME, bytes(8), 1), 0.1) == [
        FrameDiscarded(DiscardReason.NOISE, b"boot\r\n"),
        Frames(ids.TIME, [bytes(8)]),
    ]


def test_noise_without_frames_is_reported_after_a_while() -> None:
    one = detector()
    assert one.feed(b"Marlin\r\n", 5.0) == []
    assert one.get_timer() == 5.0 + HOLD_NOISE_S
    assert one.handle_timer(5.0 + HOLD_NOISE_S) == [FrameDiscarded(DiscardReason.NOISE, b"Marlin\r\n")]
    assert one.get_timer() is None


def test_much_noise_does_not_wait() -> None:
    one = detector()
    found = []
    for _ in range(2 * MAX_HELD):
        found += one.feed(b"text", 0.0)
    assert len(found) > MAX_HELD / 2


def test_noise_that_looks_like_version_1_hides_no_version_2_frame() -> None:
    one = detector()
    one.feed(b"\xff\xff\x0a\x00\x00\x80" + frame(ids.TIME, bytes(8)), 0.0)
    assert one.decoder is not None
    assert one.decoder.version == 2


def test_abandon_returns_the_remaining_events() -> None:
    one = detector()
    one.feed(b"text" + frame(ids.TIME, bytes(8))[:9], 0.0)
    assert [item.data for item in one.abandon(1.0) if isinstance(item, FrameDiscarded)] == [
        b"text",
        frame(ids.TIME, bytes(8))[:9],
    ]


def test_new_limits_apply_to_headers_seen_before() -> None:
    one = detector()
    one.feed(frame(125, bytes(300), 1), 0.0)
    one.use_limits(PayloadLimits(CONTROL_LIMITS, {None: 100}))
    message = frame(125, bytes(300), 2)
    one.feed(message, 0.0)
    assert one.decoder is None
