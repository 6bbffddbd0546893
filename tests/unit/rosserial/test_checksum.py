from __future__ import annotations

import random

import pytest

from rostether.rosserial.checksum import PIECE_BYTES, RunningSums, one_plus_sum, sum_function

SIZES = (0, 1, 2, 255, 256, 257, 511, 512, 513, 768, 4096, 65535)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("fill", [b"\x00", b"\xff", b"\xfe"])
def test_extreme_bytes_sum_exactly(size: int, fill: bytes) -> None:
    data = fill * size
    assert one_plus_sum(data) & 0xFF == (1 + sum(data)) & 0xFF
    assert sum_function(size)(data) & 0xFF == (1 + sum(data)) & 0xFF


def test_random_bytes_sum_exactly() -> None:
    rng = random.Random(1)
    for _ in range(300):
        data = rng.randbytes(rng.randrange(3 * PIECE_BYTES))
        assert one_plus_sum(data) & 0xFF == (1 + sum(data)) & 0xFF


def test_a_piece_never_reaches_the_modulus() -> None:
    assert 1 + PIECE_BYTES * 255 < 65521


def test_running_sums_of_any_stretch() -> None:
    data = random.Random(2).randbytes(1000)
    sums = RunningSums(data)
    for start, end in ((0, 0), (0, 1000), (17, 400), (999, 1000)):
        assert sums.one_plus_sum(start, end) == 1 + sum(data[start:end])
