from __future__ import annotations

import statistics

import pytest

from rostether.mechanisms.median import median


def test_it_is_that_of_the_standard_library() -> None:
    for values in ([3.0], [2.0, 1.0], [5.0, 1.0, 9.0], [4.0, -1.0, 2.5, 8.0]):
        assert median(iter(values)) == statistics.median(values)
    with pytest.raises(IndexError):
        median([])
