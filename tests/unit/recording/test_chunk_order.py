"""Messages of chunks by time: overlapping chunks, closed chunks, and chunks that are too large to list."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from rostether.recording import chunk_order
from rostether.recording.chunk_order import Entry, Unpacked, in_order
from rostether.recording.compression import StoredChunk


class _Chunk(StoredChunk, frozen=True):
    times: tuple[int, ...] = ()


def _chunk(*times: int) -> _Chunk:
    return _Chunk(0, 0, "bz2", len(times), min(times), max(times), None, times)


class _File:
    """Chunks whose messages have one byte; counts how often and how many were open."""

    def __init__(self, *chunks: _Chunk) -> None:
        self.chunks = sorted(chunks, key=lambda chunk: chunk.start_ns)
        self.opened: list[int] = []

    def unpack(self, chunk: StoredChunk) -> Unpacked:
        assert isinstance(chunk, _Chunk)
        self.opened.append(self.chunks.index(chunk))

        def walk() -> Iterator[Entry]:
            for place, time_ns in enumerate(chunk.times):
                yield time_ns, place, place + 1, 7

        return bytes(place % 256 for place in range(len(chunk.times))), walk

    def times(self, start_ns: int | None = None, end_ns: int | None = None) -> list[int]:
        found = in_order(self.chunks, self.unpack, start_ns=start_ns, end_ns=end_ns)
        return [time_ns for number, time_ns, _ in found if number == 7]


def _overlapping(count: int) -> _File:
    rng = random.Random(5)
    return _File(*(_chunk(*(rng.randrange(1000) for _ in range(20))) for _ in range(count)))


def test_consecutive_chunks_are_opened_one_at_a_time() -> None:
    file = _File(_chunk(1, 2, 3), _chunk(4, 5), _chunk(6))
    found = in_order(file.chunks, file.unpack)
    next(found)
    assert file.opened == [0]
    assert [time_ns for _, time_ns, _ in found] == [2, 3, 4, 5, 6]
    assert file.opened == [0, 1, 2]


def test_overlapping_chunks_are_merged() -> None:
    file = _overlapping(30)
    assert file.times() == sorted(time_ns for chunk in file.chunks for time_ns in chunk.times)
    assert len(file.opened) == 30
    assert _overlapping(30).times(200, 300) == [each for each in file.times() if 200 <= each <= 300]


def test_chunks_that_need_too_much_memory_are_closed_and_opened_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(chunk_order, "MAX_OPEN_BYTES", 15_000)
    file = _overlapping(30)
    assert file.times() == sorted(time_ns for chunk in file.chunks for time_ns in chunk.times)
    assert len(file.opened) > 30


def test_each_time_has_its_payload(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunk_order, "MAX_OPEN_BYTES", 1000)
    file = _File(_chunk(5, 1, 3), _chunk(2, 6, 4))
    assert [(time_ns, payload[0]) for _, time_ns, payload in in_order(file.chunks, file.unpack)] == [
        *((1, 1), (2, 0), (3, 2)),
        *((4, 2), (5, 0), (6, 1)),
    ]


@pytest.mark.parametrize("times", [tuple(range(200)), tuple(reversed(range(200)))])
def test_large_chunks_are_read_without_a_list(
    monkeypatch: pytest.MonkeyPatch, times: tuple[int, ...]
) -> None:
    monkeypatch.setattr(chunk_order, "MAX_LISTED_BYTES", 100)
    file = _File(_chunk(*times), _chunk(50, 60))
    assert file.times() == sorted((*times, 50, 60))


def test_messages_with_equal_times_keep_their_order() -> None:
    file = _File(_chunk(1, 1, 1), _chunk(1, 1))
    found = [payload[0] for _, _, payload in in_order(file.chunks, file.unpack)]
    assert found == [0, 1, 2, 0, 1]
