from __future__ import annotations

from rostether.transports.xbee.packets import TransmitStatus
from rostether.transports.xbee.send_queue import (
    QUEUE_LIMIT_BYTES,
    STATUS_LIMIT_S,
    Finished,
    Packet,
    SendQueue,
)

DELIVERED, NO_ACKNOWLEDGEMENT = 0, 1


class Radio:
    """A queue for packets of 10 bytes, and the radio behind it."""

    def __init__(self) -> None:
        self.queue: SendQueue[str] = SendQueue(lambda: 10)
        self.on_way: list[Packet[str]] = []
        self.sent: list[tuple[str, bytes]] = []

    def send(self, now_s: float = 0.0) -> None:
        for packet in self.queue.next_packets(now_s):
            self.on_way.append(packet)
            self.sent.append((packet.key, packet.payload))

    def finish(self, status: int = DELIVERED) -> Finished[str] | None:
        """Report the end of the oldest packet."""
        packet = self.on_way.pop(0)
        return self.queue.finished(TransmitStatus(packet.frame_id, status, None))

    def run(self, lost: str = "") -> None:
        self.send()
        while self.on_way:
            self.finish(NO_ACKNOWLEDGEMENT if self.on_way[0].key == lost else DELIVERED)
            self.send()


def test_boards_take_turns_and_a_message_stays_together() -> None:
    radio = Radio()
    radio.queue.put("a", bytes(50))
    radio.queue.put("b", bytes(15))
    radio.run()
    assert [key for key, _ in radio.sent] == ["a", "a", "a", "b", "b", "a", "a"]
    assert radio.queue.is_empty


def test_two_packets_wait_for_their_status() -> None:
    radio = Radio()
    radio.queue.put("a", bytes(30))
    radio.send()
    assert len(radio.sent) == 2
    assert radio.finish() == Finished("a", TransmitStatus(1, DELIVERED, None))
    radio.send()
    assert len(radio.sent) == 3
    assert radio.queue.waiting_bytes("a") == 0


def test_boards_that_do_not_answer_share_one_slot() -> None:
    radio = Radio()
    for board in ("dead", "gone"):
        radio.queue.put(board, bytes(10))
        radio.send()
        radio.finish(NO_ACKNOWLEDGEMENT)
    for board in ("dead", "gone", "well"):
        radio.queue.put(board, bytes(10))
    radio.sent.clear()
    radio.send()
    assert [key for key, _ in radio.sent] == ["dead", "well"]
    radio.queue.note_received("gone")
    radio.queue.put("well", bytes(10))
    radio.on_way.reverse()
    radio.finish()
    radio.send()
    # It has sent something, so it no longer waits for the dead one.
    assert [key for key, _ in radio.sent] == ["dead", "well", "gone"]


def test_a_packet_without_a_report_counts_as_lost_after_the_limit() -> None:
    radio = Radio()
    radio.queue.put("a", bytes(10))
    radio.send(now_s=5.0)
    assert radio.queue.get_timer() == 5.0 + STATUS_LIMIT_S
    assert radio.queue.give_up(5.5) == []
    assert radio.queue.give_up(5.0 + STATUS_LIMIT_S) == [Finished("a", None)]
    assert radio.queue.get_timer() is None
    assert radio.finish() is None


def test_a_full_queue_refuses_bytes() -> None:
    queue: SendQueue[str] = SendQueue(lambda: 100)
    # One message that is longer on its own is sent.
    assert queue.put("a", bytes(QUEUE_LIMIT_BYTES + 1))
    assert not queue.put("a", b"x")
    assert queue.put("b", b"x")


def test_a_disconnected_board_still_gets_what_waits() -> None:
    radio = Radio()
    radio.queue.put("a", bytes(10))
    radio.queue.put("b", b"")
    radio.queue.release("a")
    radio.queue.release("b")
    radio.run()
    assert [key for key, _ in radio.sent] == ["a"]
    for number in range(1000):
        radio.queue.put(str(number), b"x")
        radio.queue.release(str(number))
    radio.sent.clear()
    radio.run()
    assert len(radio.sent) < 200
