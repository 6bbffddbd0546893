from __future__ import annotations

from rostether.gateways.websocket.topic_queues import MESSAGE_COST_BYTES, TURN_BYTES, TopicQueues


class Waiting(TopicQueues[int, int]):
    def __init__(self, max_bytes: int) -> None:
        super().__init__(max_bytes, self.count)
        self.dropped: list[int] = []

    def count(self, topic: int) -> None:
        self.dropped.append(topic)


def drain(waiting: Waiting) -> list[tuple[int, int, bytes]]:
    found = []
    while waiting:
        found.append(waiting.pop())
    return found


def test_topics_take_turns_and_keep_their_order() -> None:
    waiting = Waiting(1_000_000)
    image = bytes(TURN_BYTES)
    waiting.add(1, 5, [image, image, image])
    waiting.add(2, 6, [b"x", b"y"])
    assert waiting.pop() == (1, 5, image)
    waiting.add(2, 7, [b"z"])
    # Small messages do not wait for one image each.
    found = [(topic, tag, payload[:1]) for topic, tag, payload in drain(waiting)]
    assert found == [(2, 6, b"x"), (2, 6, b"y"), (2, 7, b"z"), (1, 5, b"\0"), (1, 5, b"\0")]


def test_old_images_are_dropped_and_small_messages_and_the_newest_image_are_not() -> None:
    waiting = Waiting(10_000_000)
    image = bytes(TURN_BYTES)
    for now_s in (0.0, 0.5, 1.4, 5.0):
        waiting.add(1, int(now_s * 10), [image], now_s, max_age_s=1.0)
        waiting.add(2, int(now_s * 10), [b"x"], now_s, max_age_s=1.0)
        if now_s == 1.4:
            assert waiting.dropped == [1]
    assert [(topic, tag) for topic, tag, _ in drain(waiting)] == [(1, 50), (2, 0), (2, 5), (2, 14), (2, 50)]
    assert waiting.dropped == [1, 1, 1]


def test_the_fullest_topic_loses_its_oldest() -> None:
    waiting = Waiting(20 * (10 + MESSAGE_COST_BYTES))
    waiting.add(2, 0, [b"quiet     "])
    for number in range(100):
        waiting.add(1, number, [b"%010d" % number])
    left = drain(waiting)
    assert (2, 0, b"quiet     ") in left
    times = [time_ns for subscription_id, time_ns, _ in left if subscription_id == 1]
    assert times == list(range(100 - len(times), 100))
    assert waiting.dropped == [1] * (101 - len(left))
    assert 16 <= len(left) <= 20


def test_one_message_larger_than_all_room_is_kept_until_the_next() -> None:
    waiting = Waiting(1000)
    waiting.add(1, 1, [b"x" * 5000])
    waiting.add(1, 2, [b"y" * 5000])
    assert drain(waiting) == [(1, 2, b"y" * 5000)]
    assert waiting.dropped == [1]


def test_what_waits_for_a_subscription_that_ended_is_forgotten() -> None:
    waiting = Waiting(1000)
    waiting.add(1, 1, [b"x" * 500])
    waiting.add(2, 1, [b"y"])
    waiting.forget(1)
    waiting.forget(7)
    waiting.add(2, 2, [b"z" * 500])
    assert [message[2][:1] for message in drain(waiting)] == [b"y", b"z"]
    assert waiting.dropped == []


def test_a_topic_keeps_no_more_messages_than_it_wants() -> None:
    waiting = Waiting(100_000)
    waiting.add(1, 5, [b"a", b"b"], max_messages=3)
    waiting.add(1, 6, [b"c", b"d"], max_messages=3)
    waiting.add(2, 7, [b"x"])
    assert drain(waiting) == [(1, 5, b"b"), (1, 6, b"c"), (1, 6, b"d"), (2, 7, b"x")]
    assert waiting.dropped == [1]
