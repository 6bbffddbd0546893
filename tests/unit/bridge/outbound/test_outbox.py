from __future__ import annotations

import re
from asyncio import AbstractEventLoop
from typing import cast

import pytest

from rostether.bridge.outbound.outbox import MIN_QUEUE_BYTES, Outbox
from rostether.bridge.outbound.topic_queue import TopicQueue
from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.errors import LocalProtocolError
from rostether.rosserial.host_link import HostLink
from unit.bridge.doubles import FakeLink, FakeSerialPort, FakeSource, FakeTransport, ManualLoop


class Bench:
    """An outbox whose link and sources the test controls."""

    def __init__(
        self, *, can_pause: bool = True, baud: int | None = None, bytes_per_s: float | None = None
    ) -> None:
        self.loop = ManualLoop()
        self.transport = FakeTransport(can_pause=can_pause)
        if baud is not None:
            self.transport = FakeSerialPort(self.loop, bytes_per_s or baud / 10)
        self.link = FakeLink()
        self.dropped: list[tuple[str, int]] = []
        self.outbox = Outbox(
            self.transport,
            cast(HostLink, self.link),
            cast(AbstractEventLoop, self.loop),
            on_dropped=lambda queue, count: self.dropped.append((queue.topic, count)),
            settings=BridgeSettings(stall_s=1.0),
            baud=baud,
        )

    def block(self, unsent_bytes: int = 65536) -> None:
        self.transport.write_buffer_bytes = unsent_bytes
        self.outbox.pause_writing()

    def ids_written(self) -> list[int]:
        return [int(found) for found in re.findall(rb"(\d+):", self.transport.written)]


def test_one_write_a_turn() -> None:
    bench = Bench()
    first, second = TopicQueue(101, "a"), TopicQueue(102, "b")
    bench.outbox.put(first, [b"1"])
    bench.outbox.put(second, [b"2"])
    bench.outbox.put(first, [b"3"])
    assert bench.transport.writes == []
    bench.loop.turn()
    assert bench.transport.writes == [b"101:1;101:3;102:2;"]
    bench.loop.turn()
    assert len(bench.transport.writes) == 1


def test_after_a_pause_nothing_waits_for_the_next_turn() -> None:
    bench = Bench()
    bench.loop.run_until(1.0)
    queue = TopicQueue(101, "a")
    bench.outbox.put(queue, [b"1"])
    assert bench.transport.writes == [b"101:1;"]
    bench.outbox.put(queue, [b"2"])
    bench.outbox.put(queue, [b"3"])
    assert len(bench.transport.writes) == 1
    bench.loop.turn()
    assert bench.transport.writes[1:] == [b"101:2;101:3;"]


def test_answers_and_control_traffic_go_first() -> None:
    bench = Bench()
    bench.outbox.put(TopicQueue(101, "a"), [b"1"])
    bench.outbox.answer(110, b"response")
    bench.link.control.append(b"time;")
    bench.loop.turn()
    assert bench.transport.writes == [b"110:response;time;101:1;"]


def test_topics_are_sent_in_turns() -> None:
    bench = Bench()
    flood, quiet = TopicQueue(101, "flood"), TopicQueue(102, "quiet")
    bench.outbox.put(flood, [b"x" * 992] * 100)
    bench.outbox.put(quiet, [b"command"])
    bench.loop.turn()
    assert bench.ids_written().index(102) <= 5
    assert bench.ids_written().count(101) == 100


def test_a_blocked_link_gets_answers_and_nothing_else() -> None:
    bench = Bench()
    bench.block()
    bench.outbox.put(TopicQueue(101, "a"), [b"1"])
    bench.loop.turn()
    assert bench.transport.writes == []
    bench.link.control.append(b"time;")
    bench.outbox.flush()
    bench.outbox.answer(110, b"r")
    bench.loop.turn()
    assert bench.transport.writes == [b"time;", b"110:r;"]
    bench.outbox.resume_writing()
    bench.loop.turn()
    assert bench.transport.writes[2:] == [b"101:1;"]


def test_a_board_without_room_gets_what_fits_until_it_has_room() -> None:
    bench = Bench()
    bench.loop.run_until(1.0)
    bench.link.unread.room_bytes = 26
    small, large = TopicQueue(101, "small"), TopicQueue(102, "large")
    bench.outbox.put(large, [bytes(40)])
    bench.outbox.put(small, [b"1"])
    bench.outbox.put(small, [b"2", b"3", b"4"])
    bench.loop.turn()
    assert bench.ids_written() == [101, 101, 101]
    bench.link.unread.room_bytes = 3
    bench.outbox.put(small, [b"5"])
    bench.loop.turn()
    assert bench.ids_written() == [101, 101, 101]
    bench.link.unread.room_bytes = None
    bench.outbox.flush()
    assert sorted(bench.ids_written()) == [101, 101, 101, 101, 101, 102]


def test_a_dead_link_gets_limited_data() -> None:
    bench = Bench()
    bench.block(unsent_bytes=2 << 20)
    bench.link.control.append(b"time;")
    bench.outbox.flush()
    assert bench.transport.writes == []


def test_overflow_pauses_the_source_and_loses_nothing() -> None:
    bench = Bench()
    queue, source = TopicQueue(101, "flood"), FakeSource()
    queue.set_source(source)
    bench.block()
    sent = 0
    while not source.is_paused:
        bench.outbox.put(queue, [b"x" * 992] * 10)
        sent += 10
    assert sent * 1000 > DEFAULT_SETTINGS.queue_bytes
    bench.outbox.resume_writing()
    bench.loop.run_until(0.01)
    assert not source.is_paused
    assert bench.ids_written().count(101) == sent
    assert bench.dropped == []


def test_a_hanging_board_delays_the_end_by_a_second_at_most() -> None:
    bench = Bench()
    queue, source = TopicQueue(101, "flood"), FakeSource()
    queue.set_source(source)
    bench.block()
    bench.outbox.put(queue, [b"x" * 992] * 200)
    assert source.is_paused
    bench.loop.run_until(0.9)
    assert source.is_paused
    bench.loop.run_until(1.3)
    assert not source.is_paused
    bench.outbox.put(queue, [b"y" * 992] * 200)
    assert not source.is_paused
    assert queue.queued_bytes <= DEFAULT_SETTINGS.queue_bytes
    assert queue.payloads[-1] == b"y" * 992
    assert bench.dropped == [("flood", queue.dropped_count)]


def test_a_slow_board_that_accepts_bytes_is_waited_for() -> None:
    bench = Bench()
    queue, source = TopicQueue(101, "flood"), FakeSource()
    queue.set_source(source)
    bench.block()
    bench.outbox.put(queue, [b"x" * 992] * 200)
    for step in range(50):
        bench.transport.write_buffer_bytes -= 1
        bench.loop.run_until(step * 0.1)
    assert source.is_paused
    assert bench.dropped == []


def test_a_board_that_hung_and_accepts_bytes_again_is_waited_for_again() -> None:
    bench = Bench()
    queue, source = TopicQueue(101, "flood"), FakeSource()
    queue.set_source(source)
    bench.block()
    bench.outbox.put(queue, [b"x" * 992] * 200)
    bench.loop.run_until(2.0)
    bench.outbox.resume_writing()
    bench.loop.run_until(2.1)
    bench.block()
    bench.outbox.put(queue, [b"x" * 992] * 200)
    assert source.is_paused


def test_without_a_source_to_pause_the_oldest_messages_are_dropped() -> None:
    bench = Bench()
    queue = TopicQueue(101, "flood")
    bench.block()
    bench.outbox.put(queue, [b"%04d" % number for number in range(20_000)])
    assert queue.queued_bytes <= DEFAULT_SETTINGS.queue_bytes
    assert queue.payloads[-1] == b"19999"
    assert bench.dropped == [("flood", 20_000 - len(queue.payloads))]


def test_a_resumed_source_that_sends_immediately_keeps_the_order() -> None:
    bench = Bench()
    queue = TopicQueue(101, "flood")

    class EagerSource(FakeSource):
        def resume(self) -> None:
            super().resume()
            bench.outbox.put(queue, [b"late" * 250] * 200)

    source = EagerSource()
    queue.set_source(source)
    bench.block()
    bench.outbox.put(queue, [b"early" * 200] * 200)
    assert source.is_paused
    bench.outbox.resume_writing()
    bench.loop.run_until(1.0)
    order = re.sub(rb"101:((early)+|(late)+);", rb"\2\3 ", bench.transport.written).split()
    assert order[:200] == [b"early"] * 200
    assert set(order[200:]) == {b"late"}


def test_a_serial_line_gets_little_at_a_time_and_all_of_it() -> None:
    bench = Bench(baud=57600)
    queue = TopicQueue(101, "commands")
    bench.outbox.put(queue, [b"x" * 56] * 100)
    bench.loop.turn()
    assert len(bench.transport.written) < 300
    bench.loop.run_until(0.5)
    assert 0.4 * 5760 < len(bench.transport.written) < 0.6 * 5760
    bench.loop.run_until(2.0)
    assert bench.ids_written().count(101) == 100


def test_a_board_with_native_usb_gets_more_than_its_baud_rate() -> None:
    bench = Bench(baud=57600, bytes_per_s=1_000_000)
    queue = TopicQueue(101, "images")
    bench.outbox.put(queue, [b"x" * 492] * 20)
    bench.loop.run_until(0.2)
    assert bench.ids_written().count(101) == 20


def test_on_a_busy_serial_line_answers_wait_for_nothing() -> None:
    bench = Bench(baud=57600)
    bench.outbox.put(TopicQueue(101, "commands"), [b"x" * 56] * 100)
    bench.loop.turn()
    bench.link.control.append(b"time;")
    bench.outbox.flush()
    assert bench.transport.writes[-1] == b"time;"


def test_a_serial_line_drops_the_oldest_of_the_topic_that_floods() -> None:
    bench = Bench(baud=9600)
    flood, quiet, source = TopicQueue(101, "flood"), TopicQueue(102, "quiet"), FakeSource()
    flood.set_source(source)
    bench.outbox.put(quiet, [b"command"])
    bench.outbox.put(flood, [b"%092d" % number for number in range(1000)])
    assert not source.is_paused
    assert flood.queued_bytes <= MIN_QUEUE_BYTES
    assert bench.dropped == [("flood", flood.dropped_count)]
    bench.loop.run_until(0.1)
    assert 102 in bench.ids_written()
    bench.loop.run_until(60.0)
    assert b"%092d" % 999 in bench.transport.written


def test_a_topic_that_the_board_no_longer_accepts_stops_no_other() -> None:
    bench = Bench()
    gone, there = TopicQueue(101, "gone"), TopicQueue(102, "there")
    bench.link.refused.add(101)
    bench.outbox.put(gone, [b"1", b"2"])
    bench.outbox.put(there, [b"3"])
    bench.loop.turn()
    assert bench.transport.writes == [b"102:3;"]
    assert gone.dropped_count == 2


def test_an_answer_that_cannot_be_sent_is_reported() -> None:
    bench = Bench()
    bench.link.refused.add(110)
    with pytest.raises(LocalProtocolError):
        bench.outbox.answer(110, b"r")


def test_a_removed_topic_leaves_nothing_behind() -> None:
    bench = Bench()
    queue, source = TopicQueue(101, "flood"), FakeSource()
    queue.set_source(source)
    bench.block()
    bench.outbox.put(queue, [b"x" * 992] * 200)
    bench.outbox.remove(queue)
    assert not source.is_paused
    assert bench.outbox.queued_bytes == 0
    bench.outbox.resume_writing()
    bench.loop.turn()
    assert bench.transport.writes == []


def test_closing_lets_go_of_paused_sources() -> None:
    bench = Bench()
    queue, source = TopicQueue(101, "flood"), FakeSource()
    queue.set_source(source)
    bench.block()
    bench.outbox.put(queue, [b"x" * 992] * 200)
    bench.outbox.close()
    assert not source.is_paused
    bench.loop.run_until(10.0)
    assert bench.transport.writes == []


def test_a_depth_keeps_the_newest_while_the_link_accepts_nothing() -> None:
    bench = Bench()
    bench.block()
    queue = TopicQueue(101, "cmd_vel", 2)
    for number in range(5):
        bench.outbox.put(queue, [b"%d" % number])
    assert bench.dropped == [("cmd_vel", 1)] * 3
    bench.outbox.resume_writing()
    bench.loop.run_until(1.0)
    assert bench.transport.written == b"101:3;101:4;"


def test_a_depth_loses_nothing_while_the_link_accepts_everything() -> None:
    bench = Bench()
    bench.outbox.put(TopicQueue(101, "cmd_vel", 1), [b"%d" % number for number in range(40)])
    bench.loop.run_until(1.0)
    assert bench.dropped == []
    assert len(bench.ids_written()) == 40
