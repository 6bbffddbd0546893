from __future__ import annotations

from rostether.mechanisms.token_bucket import TokenBucket


def test_admits_a_burst_then_the_rate() -> None:
    bucket = TokenBucket(2.0, 10, 100.0)
    assert bucket.admit(4, 100.0) == 4
    assert bucket.admit(10, 100.0) == 6
    assert bucket.admit(10, 101.2) == 2
    assert bucket.admit(10, 101.5) == 1


def test_saves_no_more_than_a_burst() -> None:
    bucket = TokenBucket(2.0, 10, 100.0)
    assert bucket.room(1000.0) == 10
    assert bucket.admit(11, 1000.0) == 10
    assert bucket.room(1000.0) == 0
