from __future__ import annotations

import pytest

from line_faults import FaultRates, LineFaults
from rostether.transports.memory import Direction

WAY = Direction.FIRST_TO_SECOND
DATA = bytes(range(256)) * 40


def test_without_rates_no_byte_changes() -> None:
    faults = LineFaults(FaultRates(), seed=1)
    assert faults(DATA, WAY) == DATA
    assert faults.fault_count == 0


def test_the_same_seed_makes_the_same_faults() -> None:
    rates = FaultRates(0.01, 0.01, 0.01, 0.1)
    one, same, other = (LineFaults(rates, seed)(DATA, WAY) for seed in (1, 1, 2))
    assert one == same != other


def test_flips_change_one_bit_each() -> None:
    faults = LineFaults(FaultRates(flip_per_byte=0.05), seed=3)
    arrived = faults(DATA, WAY)
    changed = [a ^ b for a, b in zip(DATA, arrived, strict=True) if a != b]
    assert all(bits.bit_count() == 1 for bits in changed)
    assert len(changed) == faults.fault_count
    assert 0.03 < len(changed) / len(DATA) < 0.07


@pytest.mark.parametrize(
    ("rates", "sign"), [(FaultRates(lose_per_byte=0.05), -1), (FaultRates(insert_per_byte=0.05), 1)]
)
def test_bytes_are_lost_or_added(rates: FaultRates, sign: int) -> None:
    faults = LineFaults(rates, seed=4)
    assert len(faults(DATA, WAY)) == len(DATA) + sign * faults.fault_count
    assert faults.fault_count > 100


def test_whole_chunks_are_lost() -> None:
    faults = LineFaults(FaultRates(lose_per_chunk=0.25), seed=5)
    arrived = [faults(b"chunk", WAY) for _ in range(400)]
    assert set(arrived) == {b"", b"chunk"}
    assert 60 < arrived.count(b"") < 140
