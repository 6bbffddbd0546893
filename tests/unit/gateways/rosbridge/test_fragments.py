from __future__ import annotations

import json
import random
from typing import Any

import pytest

from rostether.errors import RemoteProtocolError
from rostether.gateways.rosbridge import fragments
from rostether.gateways.rosbridge.fragments import MAX_UNFINISHED, Defragmenter, split_fragments


def pieces(text: str, size: int, message_id: str = "7") -> list[dict[str, Any]]:
    return [json.loads(each) for each in split_fragments(text, size, message_id)]


def test_pieces_have_the_size_asked_for() -> None:
    assert pieces("abcdefg", 3) == [
        {"op": "fragment", "id": "7", "data": "abc", "num": 0, "total": 3},
        {"op": "fragment", "id": "7", "data": "def", "num": 1, "total": 3},
        {"op": "fragment", "id": "7", "data": "g", "num": 2, "total": 3},
    ]


def test_pieces_in_any_order_become_the_text() -> None:
    joiner = Defragmenter(1000)
    text = "äöü" * 50
    mixed = pieces(text, 7)
    random.Random(1).shuffle(mixed)
    assert [joiner.add(each) for each in mixed] == [None] * (len(mixed) - 1) + [text]


def test_messages_may_be_mixed_and_pieces_come_twice() -> None:
    joiner = Defragmenter(100)
    first, second = pieces("abcdef", 3, "a"), pieces("uvwxyz", 3, "b")
    assert joiner.add(first[0]) is None
    assert joiner.add(second[1]) is None
    assert joiner.add(first[0]) is None
    assert joiner.add(second[0]) == "uvwxyz"
    assert joiner.add(first[1]) == "abcdef"


def test_another_total_begins_again() -> None:
    joiner = Defragmenter(100)
    assert joiner.add(pieces("abcdef", 3)[0]) is None
    again = pieces("uvwxyz", 2)
    assert [joiner.add(each) for each in again] == [None, None, "uvwxyz"]


def test_memory_is_bounded_and_the_newest_is_kept() -> None:
    joiner = Defragmenter(20)
    for number in range(100):
        joiner.add({"id": f"left {number}", "data": "x" * 10, "num": 0, "total": 2})
    assert [joiner.add(each) for each in pieces("abcdef", 3)] == [None, "abcdef"]
    with pytest.raises(RemoteProtocolError, match="at most 20 bytes"):
        joiner.add({"id": "large", "data": "x" * 21, "num": 0, "total": 2})


def test_unfinished_messages_are_counted() -> None:
    joiner = Defragmenter(1000)
    first = pieces("abcdef", 3, "first")
    joiner.add(first[0])
    for number in range(MAX_UNFINISHED):
        joiner.add({"id": number, "data": "", "num": 0, "total": 2})
    assert joiner.add(first[1]) is None


def test_empty_pieces_take_room_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fragments, "MAX_UNFINISHED_PIECES", 10)
    joiner = Defragmenter(1000)
    first = pieces("abcdef", 2, "first")
    joiner.add(first[0])
    for number in range(10):
        joiner.add({"id": "hollow", "data": "", "num": number, "total": 100})
    assert joiner.add(first[1]) is None
    assert joiner.add(first[2]) is None
    assert joiner.add(first[0]) == "abcdef"


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"id": "a", "num": 0, "total": 1},
        {"id": "a", "data": 5, "num": 0, "total": 1},
        {"id": [], "data": "", "num": 0, "total": 1},
        {"id": "a", "data": "", "num": 1, "total": 1},
        {"id": "a", "data": "", "num": -1, "total": 1},
        {"id": "a", "data": "", "num": "0", "total": 1},
        {"id": "a", "data": "", "num": True, "total": 2},
        {"id": "a", "data": "", "num": 0, "total": 10**9},
    ],
)
def test_what_is_not_a_fragment_is_reported(fields: dict[str, Any]) -> None:
    with pytest.raises(RemoteProtocolError, match="fragment: "):
        Defragmenter(100).add(fields)
