from __future__ import annotations

import pytest

from rostether.bridge.outbound.line_pacer import MAX_SPEED_FACTOR, MIN_WINDOW_BYTES, WINDOW_S, LinePacer


def test_an_idle_line_accepts_its_window() -> None:
    assert LinePacer(115200).room_bytes(0.0) == int(11520 * WINDOW_S)


def test_a_slow_line_still_accepts_a_small_frame() -> None:
    assert LinePacer(300).room_bytes(0.0) == MIN_WINDOW_BYTES


def test_room_returns_at_the_speed_of_the_line() -> None:
    pacer = LinePacer(100_000)
    pacer.written(200, 1.0)
    assert pacer.room_bytes(1.0) == 0
    assert 99 <= pacer.room_bytes(1.010) <= 101
    assert pacer.room_bytes(1.020) == 200


def test_a_message_larger_than_the_window_delays_the_next() -> None:
    pacer = LinePacer(100_000)
    pacer.written(1000, 0.0)
    assert pacer.room_bytes(0.0) == -800
    assert pacer.room_bytes(0.080) <= 1
    assert abs(pacer.wait_s(0.0) - 0.090) < 1e-9


def test_the_wait_ends_when_half_of_the_window_is_free() -> None:
    pacer = LinePacer(100_000)
    pacer.written(200, 0.0)
    assert abs(pacer.wait_s(0.0) - 0.010) < 1e-9
    assert pacer.wait_s(5.0) == 0.001


def line_rate(true_bytes_per_s: float, *, adapter_bytes: int = 0, seconds: float = 2.0) -> tuple[float, int]:
    """Feed a 57600 baud port with a line of another speed, and an adapter's buffer, behind it.

    Return the bytes sent per second, and the largest number of bytes that waited in port and adapter.
    """
    pacer, now_s = LinePacer(57600), 0.0
    waiting, left, max_waiting = 0.0, 0.0, 0.0
    while now_s < seconds:
        pacer.observe(int(max(0.0, waiting - adapter_bytes)), now_s)
        while pacer.room_bytes(now_s) > 0:
            pacer.written(64, now_s)
            waiting += 64
        max_waiting = max(max_waiting, waiting)
        wait_s = pacer.wait_s(now_s)
        gone = min(waiting, true_bytes_per_s * wait_s)
        waiting -= gone
        left += gone
        now_s += wait_s
    return left / seconds, int(max_waiting)


def test_a_line_of_its_baud_rate_is_kept_busy_with_little_on_its_way() -> None:
    rate, max_waiting = line_rate(5760)
    assert rate > 0.95 * 5760
    assert max_waiting < 300


def test_a_board_with_built_in_usb_is_not_limited_to_a_baud_rate_that_it_ignores() -> None:
    rate, _ = line_rate(1_000_000)
    assert rate > 200_000


@pytest.mark.parametrize("adapter_bytes", [128, 576])
def test_an_adapters_buffer_is_filled_and_little_more(adapter_bytes: int) -> None:
    rate, max_waiting = line_rate(5760, adapter_bytes=adapter_bytes)
    assert rate > 0.95 * 5760
    assert max_waiting < adapter_bytes * 3 + 300


def test_the_speed_is_bounded() -> None:
    pacer = LinePacer(57600)
    for _ in range(100):
        pacer.written(10_000, 0.0)
        pacer.observe(0, 0.0)
    assert pacer.room_bytes(0.0) == int(5760 * MAX_SPEED_FACTOR * WINDOW_S)
