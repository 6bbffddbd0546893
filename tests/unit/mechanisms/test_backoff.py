from __future__ import annotations

import pytest

from rostether.mechanisms.backoff import Backoff


def test_double_up_to_the_limit() -> None:
    backoff = Backoff(first_s=0.1, limit_s=1.0, jitter=0.0)
    assert [backoff.next_delay_s() for _ in range(6)] == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.0, 1.0])


def test_begin_again_after_success() -> None:
    backoff = Backoff(first_s=0.1, jitter=0.0)
    backoff.next_delay_s()
    backoff.next_delay_s()
    backoff.reset()
    assert backoff.next_delay_s() == pytest.approx(0.1)


def test_jitter_only_shortens() -> None:
    backoff = Backoff(first_s=1.0, limit_s=1.0, jitter=0.5)
    delays = [backoff.next_delay_s() for _ in range(50)]
    assert all(0.5 <= delay <= 1.0 for delay in delays)
    assert len(set(delays)) > 40


def test_two_backoffs_have_different_delays() -> None:
    assert (
        Backoff(first_s=1.0, limit_s=9.0).next_delay_s() != Backoff(first_s=1.0, limit_s=9.0).next_delay_s()
    )
