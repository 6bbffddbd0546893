from __future__ import annotations

import pytest

from rostether.rosserial.time_sync import HOLD_LIMIT_S, REQUEST_PERIOD_S, SYNC_LOST_S, AnswerGate, DeviceClock
from rostether.rostime import Time


class TestDeviceClock:
    def test_counts_from_boot(self) -> None:
        assert DeviceClock(50.0).time(51.25) == Time(1, 250_000_000)

    def test_the_clock_is_the_hosts_time_plus_half_the_round_trip(self) -> None:
        clock = DeviceClock(0.0)
        clock.requested(10.0)
        assert clock.answered(Time(1000, 0), 10.5) == pytest.approx(0.5)
        assert clock.time(10.5) == Time(1000, 250_000_000)
        assert clock.time(20.5) == Time(1010, 250_000_000)

    def test_an_answer_to_nothing_has_no_round_trip(self) -> None:
        clock = DeviceClock(0.0)
        assert clock.answered(Time(1000, 0), 10.0) == 0.0
        assert clock.time(10.0) == Time(1000, 0)

    def test_a_lost_answer_does_not_count(self) -> None:
        clock = DeviceClock(0.0)
        clock.requested(10.0)
        clock.requested(12.5)
        assert clock.answered(Time(1000, 0), 12.6) == pytest.approx(0.1)

    def test_waits_for_a_host_whose_clock_stopped_instead_of_jumping_back(self) -> None:
        clock = DeviceClock(0.0)
        clock.answered(Time(1000, 0), 10.0)
        assert clock.time(12.0) == Time(1002, 0)
        clock.answered(Time(1000, 0), 12.0)
        assert clock.time(12.0) == clock.time(13.5) == Time(1002, 0)
        clock.answered(Time(1000, 0), 14.0)
        assert clock.time(15.0) == Time(1002, 0)
        # The host's clock runs again.
        assert clock.time(17.0) == Time(1003, 0)

    def test_follows_a_host_whose_clock_was_reset(self) -> None:
        clock = DeviceClock(0.0)
        clock.answered(Time(1000, 0), 10.0)
        assert clock.time(10.0) == Time(1000, 0)
        clock.answered(Time(0, 0), 12.0)
        assert clock.time(13.0) == Time(1, 0)


class TestAnswerGate:
    def test_is_open_without_calls(self) -> None:
        assert not AnswerGate().is_closed(0.0)

    def test_closes_for_each_call(self) -> None:
        gate = AnswerGate()
        gate.call_started()
        gate.call_started()
        gate.call_finished()
        assert gate.is_closed(0.0)
        gate.call_finished()
        gate.call_finished()
        assert not gate.is_closed(0.0)
        gate.call_started()
        assert gate.is_closed(0.0)

    def test_opens_when_something_has_waited_long_enough(self) -> None:
        gate = AnswerGate()
        gate.call_started()
        gate.hold(10.0)
        gate.hold(12.0)
        assert gate.get_timer() == 10.0 + HOLD_LIMIT_S
        assert gate.is_closed(10.0 + HOLD_LIMIT_S - 0.1)
        assert not gate.is_closed(10.0 + HOLD_LIMIT_S)
        gate.release()
        assert gate.is_closed(20.0)
        assert gate.get_timer() is None

    def test_a_reset_device_waits_for_nothing(self) -> None:
        gate = AnswerGate()
        gate.call_started()
        gate.forget_calls()
        assert not gate.is_closed(0.0)

    def test_held_answers_are_sent_before_a_board_gives_up(self) -> None:
        assert REQUEST_PERIOD_S + HOLD_LIMIT_S < SYNC_LOST_S - 2
