from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from rostether.rosserial.clock_estimate import ClockEstimate

EPOCH_NS = 1_700_000_000 * 10**9


def run(
    estimate: ClockEstimate,
    *,
    ppm: float = 0.0,
    seconds: float = 60.0,
    delay: Callable[[float], float] = lambda _: 0.001,
    host_speed: float = 1.0,
    rate_hz: float = 20.0,
    resolution_s: float = 0.0,
) -> None:
    """Answer a board's clock every 2.5 s and let it stamp messages, which arrive after `delay`."""
    step_s = 1 / rate_hz
    answered_s = 0.0
    estimate.answered(EPOCH_NS, 0.0)
    now_s = 0.0
    while now_s < seconds:
        now_s += step_s
        elapsed_s = (now_s - answered_s) * (1 + ppm * 1e-6)
        board_s = answered_s * host_speed + elapsed_s
        if resolution_s:
            board_s = board_s // resolution_s * resolution_s
        arrived_s = now_s + delay(now_s)
        host_ns = EPOCH_NS + round(arrived_s * host_speed * 1e9)
        estimate.stamped(EPOCH_NS + round(board_s * 1e9), host_ns, arrived_s)
        if now_s - answered_s >= 2.5:
            answered_s = now_s
            estimate.answered(EPOCH_NS + round(now_s * host_speed * 1e9), now_s)


@pytest.mark.parametrize("ppm", [-5000.0, -200.0, 0.0, 50.0, 3000.0])
def test_drift_is_found(ppm: float) -> None:
    estimate = ClockEstimate()
    run(estimate, ppm=ppm)
    assert estimate.drift_ppm == pytest.approx(ppm, abs=5)


def test_delays_that_vary_are_rejected() -> None:
    rng = random.Random(1)
    estimate = ClockEstimate()
    run(estimate, ppm=1000, seconds=150, delay=lambda _: 0.001 + rng.expovariate(200))
    assert estimate.drift_ppm == pytest.approx(1000, abs=150)


def test_a_clock_that_counts_milliseconds() -> None:
    rng = random.Random(2)
    estimate = ClockEstimate()
    run(estimate, ppm=2000, seconds=150, resolution_s=0.001, rate_hz=33, delay=lambda _: 0.002 * rng.random())
    assert estimate.drift_ppm == pytest.approx(2000, abs=300)


def test_intervals_that_a_busy_line_has_spoilt_do_not_count() -> None:
    estimate = ClockEstimate()
    run(estimate, ppm=500, seconds=100, delay=lambda now_s: 0.3 if now_s % 10 > 7 else 0.001)
    assert estimate.drift_ppm == pytest.approx(500, abs=50)


def test_the_offset_is_that_just_before_the_clock_is_set_again() -> None:
    estimate = ClockEstimate()
    run(estimate, ppm=4000)
    offset_s = estimate.offset_s(round_trip_s=0.002)
    assert offset_s == pytest.approx(0.010, abs=0.001)
    slow = ClockEstimate()
    run(slow, ppm=-4000)
    assert slow.offset_s(0.002) == pytest.approx(-0.010, abs=0.001)


def test_nothing_is_reported_of_a_clock_that_was_not_seen_long_enough() -> None:
    estimate = ClockEstimate()
    assert estimate.drift_ppm is None
    assert estimate.offset_s() is None
    run(estimate, seconds=4.0)
    assert estimate.drift_ppm is None


def test_stamps_that_are_not_of_the_synchronized_clock_are_skipped() -> None:
    estimate = ClockEstimate()
    estimate.answered(EPOCH_NS, 0.0)
    for tenth in range(20):
        estimate.stamped(tenth * 10**8, EPOCH_NS + tenth * 10**8, tenth / 10)
    estimate.answered(EPOCH_NS, 2.5)
    assert estimate.offset_s() is None


def test_simulated_time_reveals_nothing_about_the_board() -> None:
    estimate = ClockEstimate()
    run(estimate, host_speed=0.5)
    assert estimate.drift_ppm is None


def test_stamps_before_a_reset_are_forgotten() -> None:
    estimate = ClockEstimate()
    estimate.answered(EPOCH_NS, 0.0)
    estimate.stamped(EPOCH_NS + 10**9, EPOCH_NS + 10**9, 1.0)
    estimate.forget()
    estimate.stamped(EPOCH_NS + 10**9, EPOCH_NS + 2 * 10**9, 2.0)
    estimate.answered(EPOCH_NS + 25 * 10**8, 2.5)
    assert estimate.offset_s() is None


def test_memory_is_limited_without_answers() -> None:
    estimate = ClockEstimate()
    estimate.answered(EPOCH_NS, 0.0)
    for tenth in range(10, 10_000):
        estimate.stamped(EPOCH_NS + tenth * 10**8, EPOCH_NS + tenth * 10**8, tenth / 10)
    assert len(estimate._samples) < 200
