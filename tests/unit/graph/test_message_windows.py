from __future__ import annotations

import pytest

from rostether.graph.message_windows import (
    DelayWindow,
    IntervalWindow,
    SizeWindow,
    format_bandwidth,
    format_delay,
    format_rate,
    format_rate_table,
    rate_record,
)


def steady(count: int, period_s: float) -> IntervalWindow:
    rates = IntervalWindow()
    for index in range(count):
        rates.add(100.0 + index * period_s)
    return rates


def test_a_steady_topic_reads_as_rostopic_hz_prints_it() -> None:
    spread = steady(11, 0.1).report()
    assert spread is not None
    assert (
        format_rate(spread) == "average rate: 10.000\n\tmin: 0.100s max: 0.100s std dev: 0.00000s window: 11"
    )


def test_no_report_without_a_new_message() -> None:
    rates = steady(3, 0.1)
    assert rates.report() is not None
    assert rates.report() is None
    rates.add(200.0)
    assert rates.report() is not None


def test_one_message_has_no_rate() -> None:
    assert steady(1, 0.1).report() is None


def test_the_window_forgets_the_oldest() -> None:
    rates = IntervalWindow(3)
    for now_s in (0.0, 10.0, 10.5, 11.0):
        rates.add(now_s)
    spread = rates.report()
    assert spread is not None
    assert (spread.mean_s, spread.window) == (0.5, 3)


def test_a_clock_that_goes_back_starts_again() -> None:
    rates = steady(5, 1.0)
    rates.add(0.0)
    assert rates.report() is None
    rates.add(0.5)
    spread = rates.report()
    assert spread is not None
    assert spread.rate_hz == 2.0


def test_messages_of_one_chunk_have_no_rate_but_do_not_divide_by_zero() -> None:
    rates = IntervalWindow()
    rates.add(1.0)
    rates.add(1.0)
    spread = rates.report()
    assert spread is not None
    assert spread.rate_hz == 0.0


def test_delay_reads_as_rostopic_delay_prints_it() -> None:
    delays = DelayWindow()
    delays.add(10.02, 10.0)
    delays.add(11.04, 11.0)
    spread = delays.report()
    assert spread is not None
    assert (
        format_delay(spread) == "average delay: 0.030\n\tmin: 0.020s max: 0.040s std dev: 0.01000s window: 2"
    )
    assert delays.report() is None


@pytest.mark.parametrize(
    ("size_bytes", "expected"),
    [
        (10, "average: 20.00B/s\n\tmean: 10.00B min: 10.00B max: 10.00B window: 2"),
        (1_000, "average: 2.00KB/s\n\tmean: 1.00KB min: 1.00KB max: 1.00KB window: 2"),
        (1_000_000, "average: 2.00MB/s\n\tmean: 1.00MB min: 1.00MB max: 1.00MB window: 2"),
    ],
)
def test_bandwidth_reads_as_rostopic_bw_prints_it(size_bytes: int, expected: str) -> None:
    sizes = SizeWindow()
    sizes.add(5.0, size_bytes)
    assert sizes.report(5.5) is None
    sizes.add(5.5, size_bytes)
    bandwidth = sizes.report(6.0)
    assert bandwidth is not None
    assert format_bandwidth(bandwidth) == expected


def test_several_topics_make_a_table() -> None:
    first, second = steady(11, 0.1).report(), steady(3, 0.5).report()
    assert first is not None
    assert second is not None
    lines = format_rate_table({"/a": first, "/bb": second}).splitlines()
    assert lines[0].split() == ["topic", "rate", "min_delta", "max_delta", "std_dev", "window"]
    assert set(lines[1]) == {"="}
    assert lines[2].split()[:2] == ["/a", "10.0"]
    assert lines[3].split()[:2] == ["/bb", "2.0"]
    assert len({len(line) for line in lines[:4]}) == 1


def test_the_json_record_names_its_units() -> None:
    spread = steady(3, 0.5).report()
    assert spread is not None
    assert rate_record("/a", spread) == {
        "topic": "/a",
        "rate_hz": 2.0,
        "mean_interval_s": 0.5,
        "min_s": 0.5,
        "max_s": 0.5,
        "std_dev_s": 0.0,
        "window": 3,
    }
