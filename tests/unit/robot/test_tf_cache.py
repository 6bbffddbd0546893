from __future__ import annotations

import pytest

from rostether.errors import ExtrapolationError
from rostether.robot.tf_cache import StaticCache, StoredTransform, TimeCache, seconds
from rostether.robot.transform import Transform

SECOND = 10**9


def entry(stamp_ns: int, parent: str = "root") -> StoredTransform:
    return StoredTransform(stamp_ns, parent, Transform((stamp_ns / SECOND, 0.0, 0.0)), "/node")


def test_entries_may_arrive_in_any_order() -> None:
    cache = TimeCache()
    for stamp_s in (103, 101, 102):
        assert cache.insert(entry(stamp_s * SECOND)) == ""
    assert cache.at(101 * SECOND + SECOND // 2).transform.translation[0] == 101.5
    assert (cache.oldest_ns, cache.latest_ns) == (101 * SECOND, 103 * SECOND)
    assert cache.rate_hz == 1.5
    assert cache.at(0).stamp_ns == 103 * SECOND


def test_repeated_and_old_entries_are_refused() -> None:
    cache = TimeCache(SECOND)
    assert cache.insert(entry(100 * SECOND)) == ""
    assert "TF_REPEATED_DATA" in cache.insert(entry(100 * SECOND))
    assert "TF_OLD_DATA" in cache.insert(entry(99 * SECOND - 1))
    assert cache.insert(entry(99 * SECOND)) == ""


def test_old_entries_are_deleted() -> None:
    cache = TimeCache(SECOND)
    for stamp_s in (100, 101, 102):
        cache.insert(entry(stamp_s * SECOND))
    assert cache.oldest_ns == 101 * SECOND
    with pytest.raises(ExtrapolationError, match="into the past"):
        cache.at(100 * SECOND)


def test_between_two_parents_the_earlier_is_valid() -> None:
    cache = TimeCache()
    cache.insert(entry(100 * SECOND, "old"))
    cache.insert(entry(101 * SECOND, "new"))
    assert cache.at(100 * SECOND + 1).parent == "old"
    assert cache.at(101 * SECOND).parent == "new"


def test_a_static_transform_is_valid_at_all_times() -> None:
    cache = StaticCache(entry(5))
    assert cache.at(0) is cache.at(10**18)
    assert cache.insert(entry(4, "other")) == ""
    assert cache.at(77).parent == "other"


def test_seconds_are_written_exactly() -> None:
    assert seconds(1_700_000_000_000_000_001) == "1700000000.000000001"
