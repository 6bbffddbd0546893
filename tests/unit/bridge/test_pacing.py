from __future__ import annotations

from rostether.bridge.pacing import MIN_WINDOW_BYTES, WINDOW_S, LinePacer


def test_an_idle_line_takes_its_window() -> None:
    assert LinePacer(115200).room_bytes(0.0) == int(11520 * WINDOW_S)


def test_a_slow_line_still_takes_a_small_frame() -> None:
    assert LinePacer(300).room_bytes(0.0) == MIN_WINDOW_BYTES


def test_room_comes_back_at_line_speed() -> None:
    pacer = LinePacer(100_000)
    pacer.written(200, 1.0)
    assert pacer.room_bytes(1.0) == 0
    assert 99 <= pacer.room_bytes(1.010) <= 101
    assert pacer.room_bytes(1.020) == 200


def test_a_message_larger_than_the_window_is_paid_for_afterwards() -> None:
    pacer = LinePacer(100_000)
    pacer.written(1000, 0.0)
    assert pacer.room_bytes(0.0) == -800
    assert pacer.room_bytes(0.080) <= 1
    assert abs(pacer.wait_s(0.0) - 0.090) < 1e-9


def test_the_wait_ends_with_half_the_window_free() -> None:
    pacer = LinePacer(100_000)
    pacer.written(200, 0.0)
    assert abs(pacer.wait_s(0.0) - 0.010) < 1e-9
    assert pacer.wait_s(5.0) == 0.001
