from __future__ import annotations

from rostether.transports.read_turn import FIRST_READ_BYTES, MIN_READ_BYTES, TURN_S, ReadTurn

MAX_BYTES = 64 * 1024
CHEAP_S = 1e-8
HOSTILE_S = 2e-6


def read(turn: ReadTurn, price_s: float, times: int = 1) -> None:
    for _ in range(times):
        turn.note_cost(turn.size_bytes, turn.size_bytes * price_s)


def test_a_flood_that_costs_little_is_read_in_large_pieces_after_few_reads() -> None:
    turn = ReadTurn(MAX_BYTES)
    assert turn.size_bytes == FIRST_READ_BYTES
    read(turn, CHEAP_S, 5)
    assert turn.size_bytes == MAX_BYTES


def test_expensive_data_is_read_in_pieces_that_fit_in_a_turn() -> None:
    turn = ReadTurn(MAX_BYTES)
    price_s = TURN_S / 10_000
    read(turn, price_s, 10)
    assert turn.size_bytes * price_s <= TURN_S
    assert turn.size_bytes > 9_000


def test_no_read_is_smaller_than_the_minimum() -> None:
    turn = ReadTurn(MAX_BYTES)
    read(turn, HOSTILE_S)
    assert turn.size_bytes == MIN_READ_BYTES


def test_after_expensive_bytes_reads_stay_small_for_some_time() -> None:
    turn = ReadTurn(MAX_BYTES)
    read(turn, HOSTILE_S)
    read(turn, CHEAP_S, 30)
    assert turn.size_bytes * HOSTILE_S < 2 * TURN_S


def test_a_high_cost_is_forgotten() -> None:
    turn = ReadTurn(MAX_BYTES)
    read(turn, HOSTILE_S)
    read(turn, CHEAP_S, 500)
    assert turn.size_bytes == MAX_BYTES


def test_after_quiet_the_first_read_is_small() -> None:
    turn = ReadTurn(MAX_BYTES)
    read(turn, CHEAP_S, 10)
    turn.note_quiet()
    assert turn.size_bytes == FIRST_READ_BYTES


def test_quiet_makes_no_read_larger() -> None:
    turn = ReadTurn(MAX_BYTES)
    read(turn, HOSTILE_S)
    turn.note_quiet()
    assert turn.size_bytes == MIN_READ_BYTES
