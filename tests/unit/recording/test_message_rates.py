from __future__ import annotations

from statistics import median

import pytest

from rostether.recording import message_rates
from rostether.recording.message_rates import _Periods


def test_the_times_between_a_few_messages_are_all_kept() -> None:
    periods = _Periods()
    for stamp in (1.0, 1.5, 3.0):
        periods.add(stamp)
    assert list(periods.kept) == [0.5, 1.5]


def test_of_very_many_messages_an_even_selection_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(message_rates, "MAX_PERIODS", 100)
    periods = _Periods()
    for number in range(100_000):
        periods.add(number * 0.01 + (number % 3) * 0.001)
        assert len(periods.kept) <= 100
    assert len(periods.kept) > 40
    assert median(periods.kept) == pytest.approx(0.011, abs=1e-9)
