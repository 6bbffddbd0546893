from __future__ import annotations

from rostether.rosserial.events import DiscardReason
from rostether.rosserial.link_statistics import LinkStatistics


def test_counts() -> None:
    statistics = LinkStatistics()
    statistics.count_discarded(DiscardReason.NOISE, 5)
    statistics.count_discarded(DiscardReason.PAYLOAD_CHECKSUM, 20)
    statistics.count_discarded(DiscardReason.PAYLOAD_CHECKSUM, 10)
    statistics.count_received(125, 3)
    statistics.count_received(125, 4)
    statistics.count_sent(100, 2, 30)
    statistics.count_sent(101, 1, 10)
    assert statistics.discarded == {DiscardReason.NOISE: 1, DiscardReason.PAYLOAD_CHECKSUM: 2}
    assert (statistics.discarded_bytes, statistics.damaged_frames) == (35, 2)
    assert statistics.messages_received == {125: 7}
    assert statistics.messages_sent == {100: 2, 101: 1}
    assert (statistics.frames_sent, statistics.bytes_sent) == (3, 40)


def test_round_trips() -> None:
    statistics = LinkStatistics()
    for round_trip_s in (0.3, 0.1, 0.2):
        statistics.count_round_trip(round_trip_s)
    assert (statistics.last_round_trip_s, statistics.shortest_round_trip_s) == (0.2, 0.1)
