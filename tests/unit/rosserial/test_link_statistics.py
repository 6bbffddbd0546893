from __future__ import annotations

from rostether.rosserial.events import DiscardReason
from rostether.rosserial.link_statistics import LinkStatistics


def test_counts() -> None:
    statistics = LinkStatistics()
    statistics.count_discarded(DiscardReason.NOISE, 5)
    statistics.count_discarded(DiscardReason.PAYLOAD_CHECKSUM, 20)
    statistics.count_discarded(DiscardReason.PAYLOAD_CHECKSUM, 10)
    assert statistics.discarded == {DiscardReason.NOISE: 1, DiscardReason.PAYLOAD_CHECKSUM: 2}
    assert (statistics.discarded_bytes, statistics.damaged_frames) == (35, 2)


def test_round_trips() -> None:
    statistics = LinkStatistics()
    for round_trip_s in (0.3, 0.1, 0.2):
        statistics.note_round_trip(round_trip_s)
    assert statistics.shortest_round_trip_s == 0.1
