from __future__ import annotations

import itertools

from rostether.rosserial.unknown_ids import FIRST_PAUSE_S, MAX_IDS, MAX_PAUSE_S, UnknownIds


def test_asks_at_once_then_ever_more_rarely() -> None:
    unknown = UnknownIds()
    asked = [second for second in range(1000) if unknown.should_ask(130, float(second))]
    assert asked[:5] == [0, 1, 3, 7, 15]
    assert max(later - earlier for earlier, later in itertools.pairwise(asked)) == MAX_PAUSE_S


def test_each_id_for_itself() -> None:
    unknown = UnknownIds()
    assert unknown.should_ask(130, 0.0)
    assert unknown.should_ask(131, 0.0)
    assert not unknown.should_ask(130, FIRST_PAUSE_S / 2)


def test_an_announced_id_starts_anew() -> None:
    unknown = UnknownIds()
    unknown.should_ask(130, 0.0)
    unknown.forget(130)
    assert unknown.should_ask(130, 0.1)


def test_memory_is_bounded() -> None:
    unknown = UnknownIds()
    for topic_id in range(100, 100 + 3 * MAX_IDS):
        unknown.should_ask(topic_id, 0.0)
    assert len(unknown._pauses) == MAX_IDS
