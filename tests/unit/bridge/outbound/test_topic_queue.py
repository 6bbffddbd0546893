from __future__ import annotations

from rostether.bridge.outbound.topic_queue import FRAME_OVERHEAD_BYTES, TopicQueue
from unit.bridge.doubles import FakeSource


def filled(*payloads: bytes) -> TopicQueue:
    queue = TopicQueue(125, "chatter")
    queue.payloads.extend(payloads)
    queue.queued_bytes = sum(map(len, payloads)) + FRAME_OVERHEAD_BYTES * len(payloads)
    return queue


def test_all_messages_that_fit_are_removed() -> None:
    queue = filled(b"a", b"bb", b"ccc")
    assert queue.pop_ready(1000) == [b"a", b"bb", b"ccc"]
    assert queue.queued_bytes == 0
    assert not queue.payloads


def test_the_oldest_messages_are_removed_in_order_and_at_least_one() -> None:
    queue = filled(b"a" * 92, b"b" * 92, b"c" * 92)
    assert queue.pop_ready(1) == [b"a" * 92]
    assert queue.pop_ready(150) == [b"b" * 92, b"c" * 92]
    assert queue.queued_bytes == 0


def test_drop_oldest_keeps_the_newest_whatever_its_size() -> None:
    queue = filled(b"a" * 92, b"b" * 92, b"c" * 9992)
    assert queue.drop_oldest(500) == 2
    assert list(queue.payloads) == [b"c" * 9992]
    assert (queue.dropped_count, queue.queued_bytes) == (2, 10_000)


def test_a_source_is_paused_and_released() -> None:
    queue, first, second = TopicQueue(125, "chatter"), FakeSource(), FakeSource()
    queue.pause_source()
    assert not queue.is_source_paused
    queue.set_source(first)
    queue.pause_source()
    assert first.is_paused
    queue.set_source(second)
    assert not first.is_paused
    assert not second.is_paused
    assert queue.has_source


def test_messages_beyond_the_depth_are_dropped_oldest_first() -> None:
    queue = filled(b"a", b"bb", b"ccc")
    assert queue.drop_beyond_depth() == 0
    queue.depth = 1
    assert queue.drop_beyond_depth() == 2
    assert list(queue.payloads) == [b"ccc"]
    assert (queue.dropped_count, queue.queued_bytes) == (2, 3 + FRAME_OVERHEAD_BYTES)
