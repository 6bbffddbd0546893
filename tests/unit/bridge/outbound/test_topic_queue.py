from __future__ import annotations

from rostether.bridge.outbound.topic_queue import FRAME_OVERHEAD_BYTES, TopicQueue
from unit.bridge.doubles import FakeSource


def filled(*payloads: bytes) -> TopicQueue:
    lane = TopicQueue(125, "chatter")
    lane.payloads.extend(payloads)
    lane.queued_bytes = sum(map(len, payloads)) + FRAME_OVERHEAD_BYTES * len(payloads)
    return lane


def test_all_messages_that_fit_are_removed() -> None:
    lane = filled(b"a", b"bb", b"ccc")
    assert lane.pop_ready(1000) == [b"a", b"bb", b"ccc"]
    assert lane.queued_bytes == 0
    assert not lane.payloads


def test_the_oldest_messages_are_removed_in_order_and_at_least_one() -> None:
    lane = filled(b"a" * 92, b"b" * 92, b"c" * 92)
    assert lane.pop_ready(1) == [b"a" * 92]
    assert lane.pop_ready(150) == [b"b" * 92, b"c" * 92]
    assert lane.queued_bytes == 0


def test_drop_oldest_keeps_the_newest_whatever_its_size() -> None:
    lane = filled(b"a" * 92, b"b" * 92, b"c" * 9992)
    assert lane.drop_oldest(500) == 2
    assert list(lane.payloads) == [b"c" * 9992]
    assert (lane.dropped_count, lane.queued_bytes) == (2, 10_000)


def test_a_source_is_paused_and_released() -> None:
    lane, first, second = TopicQueue(125, "chatter"), FakeSource(), FakeSource()
    lane.pause_source()
    assert not lane.is_source_paused
    lane.set_source(first)
    lane.pause_source()
    assert first.is_paused
    lane.set_source(second)
    assert not first.is_paused
    assert not second.is_paused
    assert lane.has_source


def test_messages_beyond_the_depth_are_dropped_oldest_first() -> None:
    lane = filled(b"a", b"bb", b"ccc")
    assert lane.drop_beyond_depth() == 0
    lane.depth = 1
    assert lane.drop_beyond_depth() == 2
    assert list(lane.payloads) == [b"ccc"]
    assert (lane.dropped_count, lane.queued_bytes) == (2, 3 + FRAME_OVERHEAD_BYTES)
