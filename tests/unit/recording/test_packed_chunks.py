from __future__ import annotations

from dataclasses import dataclass

from rostether.recording.compression import LZ4, compress
from rostether.recording.packed_chunks import compression_shares, unpack_chunk


@dataclass(frozen=True)
class Packed:
    """A chunk's place in a file."""

    compression: str
    size_bytes: int
    data_start: int
    data_end: int


def test_a_chunk_is_unpacked_from_its_place() -> None:
    plain = b"ab" * 50
    stored = compress(LZ4, plain)
    view = memoryview(b"xx" + stored + plain)
    end = 2 + len(stored)
    assert unpack_chunk(view, Packed(LZ4, 100, 2, end)) == plain
    assert unpack_chunk(view, Packed("", 100, end, end + 100)) == plain


def test_shares_are_listed_most_frequent_first() -> None:
    chunks = [Packed("lz4", 100, 0, 10), Packed("", 5, 10, 15), Packed("none", 7, 15, 22)]
    shares = compression_shares(chunks)
    assert [(each.name, each.chunk_count) for each in shares] == [("none", 2), ("lz4", 1)]
