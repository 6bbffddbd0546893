"""The queue between the executor's thread and the event loop."""

from __future__ import annotations

import threading

from rostether.ros2.rclpy.mailbox import Mailbox


class Waker:
    def __init__(self) -> None:
        self.count = 0

    def __call__(self) -> None:
        self.count += 1


def test_many_messages_wake_the_loop_once() -> None:
    wake = Waker()
    box = Mailbox(wake)
    box.put([b"a", b"b"])
    box.put([b"c"])
    assert wake.count == 1
    assert box.pop_all() == [b"a", b"b", b"c"]
    assert box.pop_all() == []
    box.put([b"d"])
    assert wake.count == 2


def test_the_oldest_go_when_it_is_full() -> None:
    box = Mailbox(Waker(), max_bytes=5)
    box.put([b"aa", b"bb"])
    box.put([b"cc"])
    assert box.dropped_count == 1
    assert box.pop_all() == [b"bb", b"cc"]
    box.put([b"dd", b"ee"])
    assert box.dropped_count == 1


def test_a_message_larger_than_the_queue_is_kept() -> None:
    box = Mailbox(Waker(), max_bytes=2)
    box.put([b"a", b"larger", b"largest"])
    assert box.pop_all() == [b"largest"]


def test_a_paused_box_keeps_what_comes() -> None:
    wake = Waker()
    box = Mailbox(wake)
    box.put([b"a"])
    box.pause()
    assert box.pop_all() == []
    box.put([b"b"])
    assert wake.count == 1
    box.resume()
    assert box.pop_all() == [b"a", b"b"]
    box.put([b"c"])
    assert wake.count == 2


def test_nothing_is_lost_between_two_threads() -> None:
    is_awake = threading.Event()
    box = Mailbox(is_awake.set)
    sent = [number.to_bytes(4, "big") for number in range(5000)]

    def put() -> None:
        for start in range(0, len(sent), 7):
            box.put(sent[start : start + 7])

    thread = threading.Thread(target=put)
    thread.start()
    received: list[bytes] = []
    while len(received) < len(sent):
        assert is_awake.wait(60)
        is_awake.clear()
        received += box.pop_all()
    thread.join()
    assert received == sent
