"""The host sends to a board with unanswered topic requests only what has room in its UART."""

from __future__ import annotations

import pytest

from rostether.rosserial.unread_bytes import (
    LONGEST_LOOP_S,
    OPENING_S,
    REQUEST_BYTES,
    STREAMED_BYTES,
    TIME_ANSWER_BYTES,
    UART_BYTES,
    UnreadBytes,
)


def asked(*sent_s: float) -> UnreadBytes:
    unread = UnreadBytes()
    for at_s in sent_s:
        unread.requested(2, REQUEST_BYTES, at_s)
    unread.version = 2
    return unread


def answer(unread: UnreadBytes, now_s: float, buffer_size: int = 280) -> None:
    unread.time_requested(now_s)
    unread.announced(buffer_size, now_s)
    unread.announced(buffer_size, now_s)


def test_a_board_that_has_answered_all_requests_has_room_for_anything() -> None:
    unread = asked(0.0)
    assert unread.room_bytes == UART_BYTES - REQUEST_BYTES
    answer(unread, 0.02)
    assert unread.room_bytes is None
    unread.sent(1000)
    assert unread.room_bytes is None


def test_each_answer_ends_one_request_and_all_bytes_before_it() -> None:
    unread = asked(0.0)
    unread.requested(1, 9, 0.2)
    unread.requested(2, REQUEST_BYTES, 0.4)
    unread.sent(15)
    unread.requested(2, REQUEST_BYTES, 0.7)
    answer(unread, 1.0)
    assert unread.room_bytes == UART_BYTES - 9 - REQUEST_BYTES - 15 - REQUEST_BYTES
    answer(unread, 2.0)
    assert unread.room_bytes == UART_BYTES - 15 - REQUEST_BYTES
    answer(unread, 3.0)
    assert unread.room_bytes is None


def test_one_time_answer_is_unread_at_most() -> None:
    unread = asked(0.0, 0.2)
    assert unread.has_room_for_time
    unread.sent(TIME_ANSWER_BYTES, is_time=True)
    assert not unread.has_room_for_time
    unread.read_all()
    assert unread.has_room_for_time


def test_a_time_request_alone_shows_that_all_before_it_was_read() -> None:
    unread = asked(0.0, 0.2)
    unread.time_requested(2.5)
    unread.requested(2, REQUEST_BYTES, 2.6)
    assert unread.get_timer() == 2.5 + OPENING_S
    unread.handle_timer(2.5 + OPENING_S)
    assert unread.room_bytes == UART_BYTES - REQUEST_BYTES


def test_requests_that_were_lost_are_given_up_after_a_loop() -> None:
    unread = asked(0.0, 0.2, 0.4, 0.7)
    answer(unread, 1.0)
    answer(unread, 2.0)
    due_s = unread.get_timer()
    assert due_s is not None
    assert 3.0 < due_s < 4.0
    unread.handle_timer(due_s)
    assert unread.room_bytes is None


def test_a_board_that_never_answers_again_is_not_waited_for() -> None:
    unread = asked(0.0, 0.2)
    answer(unread, 1.0)
    assert unread.get_timer() == 1.0 + LONGEST_LOOP_S
    unread.handle_timer(1.0 + LONGEST_LOOP_S)
    assert unread.room_bytes is None


@pytest.mark.parametrize("buffer_size", [280, STREAMED_BYTES])
def test_a_fast_board_is_never_waited_for_again(buffer_size: int) -> None:
    unread = asked(0.0)
    answer(unread, 0.02, buffer_size)
    unread.requested(2, REQUEST_BYTES, 0.12)
    answer(unread, 0.14, buffer_size)
    unread.requested(2, REQUEST_BYTES, 10.0)
    assert unread.room_bytes is None
    unread.forget()
    unread.requested(2, REQUEST_BYTES, 20.0)
    assert unread.room_bytes is not None


def test_a_board_that_introduces_itself_reads_all() -> None:
    unread = asked(0.0, 0.2, 0.4)
    unread.announced(280, 0.5)
    assert unread.room_bytes is None


def test_a_board_that_never_answers_fills_no_memory() -> None:
    unread = UnreadBytes()
    for at_s in range(10_000):
        unread.requested(2, REQUEST_BYTES, float(at_s))
    assert unread.room_bytes == 0
    assert unread.get_timer() is None
