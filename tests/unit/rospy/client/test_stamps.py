from __future__ import annotations

import pytest

from rostether.rospy.client.stamps import Duration, Time, new_stamp


@pytest.mark.parametrize(
    ("seconds", "fields"), [(1.5, (1, 500_000_000)), (-0.5, (-1, 500_000_000)), (0.1, (0, 100_000_000))]
)
def test_floats_are_split(seconds: float, fields: tuple[int, int]) -> None:
    made = Duration(seconds)
    assert (made.secs, made.nsecs) == fields
    assert Duration.from_sec(seconds) == made


def test_nanoseconds_carry_over() -> None:
    assert (Time(1, 2_500_000_000).secs, Time(1, 2_500_000_000).nsecs) == (3, 500_000_000)
    changed = Time(1)
    changed.nsecs = 3_000_000_000
    changed.canon()
    assert changed == Time(4)


def test_arithmetic() -> None:
    assert Time(5) - Time(3) == Duration(2)
    assert Time(5) + Duration(0.5) == Time(5, 500_000_000)
    assert Time(5) - Duration(2) == Time(3)
    assert Duration(3) * 2 == Duration(6) == 2 * Duration(3)
    assert Duration(3) / Duration(2) == 1.5
    assert -Duration(1, 1) == Duration(-1, -1)
    assert divmod(Duration(7), Duration(4)) == (1, Duration(3))


def test_times_and_durations_do_not_mix() -> None:
    with pytest.raises(TypeError):
        Time(1) + Time(1)
    with pytest.raises(TypeError):
        assert Time(1) < Duration(1)
    assert Time(1) != Duration(1)
    with pytest.raises(TypeError):
        Time(-1)
    with pytest.raises(ValueError, match="nsecs"):
        Time(1.5, 3)


def test_hash_order_and_truth() -> None:
    assert len({Time(1), Time(0, 1_000_000_000), Time(2)}) == 2
    assert max(Time(1), Time(2)) == Time(2)
    assert not Time()
    assert Duration(0, 1)


def test_fields_on_the_wire_are_not_checked() -> None:
    stamp = new_stamp(Time, (4_294_967_295, 4_294_967_295))
    assert (stamp.secs, stamp.nsecs) == (4_294_967_295, 4_294_967_295)
