from __future__ import annotations

import pytest

from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.loop_speed import LoopSpeed


def requests(period_s: float, count: int = 6) -> LoopSpeed:
    speed = LoopSpeed()
    for number in range(count):
        speed.request(number * period_s, 0)
    return speed


def test_a_fast_board() -> None:
    speed = requests(2.503)
    assert speed.late_s == pytest.approx(0.003)
    assert speed.find(is_listener=True) is None


def test_a_board_that_starts_late() -> None:
    finding = requests(2.8).find(is_listener=True)
    assert finding is not None
    assert finding.code is Code.SLOW_LOOP
    assert "late by 300 ms" in finding.seen


def test_a_board_that_only_publishes_may_be_slower() -> None:
    assert requests(3.0).find(is_listener=False) is None
    assert requests(3.3).find(is_listener=False) is not None


def test_answers_to_own_requests_reveal_nothing() -> None:
    speed = LoopSpeed()
    for number in range(10):
        speed.request(number * 2.7, number)
    assert speed.late_s is None


def test_a_request_that_was_overdue_counts_whatever_was_asked() -> None:
    speed = LoopSpeed()
    for number in range(4):
        speed.request(number * 3.4, number)
    assert speed.late_s == pytest.approx(0.9)


def test_one_lost_request_is_not_a_slow_loop() -> None:
    speed = LoopSpeed()
    for time_s in (0.0, 2.5, 5.0, 10.0, 12.5, 15.0):
        speed.request(time_s, 0)
    assert speed.find(is_listener=True) is None


def test_lost_datagrams_are_not_a_slow_loop() -> None:
    for may_lose in (False, True):
        speed = LoopSpeed(may_lose=may_lose)
        found = []
        for time_s in (0.0, 5.0, 10.0, 12.5, 15.0, 17.5, 20.0, 22.5, 25.0):
            speed.request(time_s, 0)
            found.append(speed.find(is_listener=False))
        assert any(found) is not may_lose


def test_after_a_reset_it_begins_again() -> None:
    speed = LoopSpeed()
    speed.request(0.0, 0)
    speed.forget()
    speed.request(4.0, 0)
    assert speed.late_s is None


def test_a_single_late_request_is_checked_again() -> None:
    speed = LoopSpeed()
    speed.request(0.0, 0)
    speed.request(3.3, 0)
    assert speed.is_suspect
    speed.request(5.8, 0)
    assert not speed.is_suspect


def test_rostethers_library_requests_sooner() -> None:
    speed = LoopSpeed()
    speed.has_own_library = True
    for number in range(5):
        speed.request(number * 2.4, 0)
    assert speed.late_s == pytest.approx(0.2)
    assert speed.find(is_listener=True) is not None


def test_a_library_that_asks_sooner_counts_as_rostethers() -> None:
    speed = LoopSpeed()
    for number in range(5):
        speed.request(number * 2.35, 0)
    assert speed.late_s == pytest.approx(0.15)


def test_jitter_does_not_hide_an_established_library() -> None:
    speed = LoopSpeed()
    for moment_s in (0.0, 2.5, 5.05, 7.4, 10.0, 12.5):
        speed.request(moment_s, 0)
    assert speed.late_s == pytest.approx(0.0, abs=0.06)
    assert speed.find(is_listener=True) is None


def test_pauses_of_a_simulator_are_not_faults_of_the_sketch() -> None:
    speed = LoopSpeed()
    for number in range(12):
        speed.request(number * 2.8, 0)
        if number % 3 == 0:
            speed.note_pause()
        assert speed.late_s is None


def test_a_slow_sketch_on_a_simulator_that_paused() -> None:
    speed = LoopSpeed()
    speed.note_pause()
    for number in range(5):
        speed.request(number * 2.8, 0)
    assert speed.find(is_listener=True) is not None
