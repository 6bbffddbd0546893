from __future__ import annotations

from rostether.recording.compression import LZ4, compress
from rostether.recording.packed_chunks import StoredChunk, compression_shares, unpack_chunk


def _packed(compression: str, size_bytes: int, start: int, end: int) -> StoredChunk:
    return StoredChunk(start, end, compression, size_bytes, 0, 0, None)


def test_a_chunk_is_unpacked_from_its_position() -> None:
    plain = b"ab" * 50
    stored = compress(LZ4, plain)
    view = memoryview(b"xx" + stored + plain)
    end = 2 + len(stored)
    assert unpack_chunk(view, _packed(LZ4, 100, 2, end)) == plain
    assert unpack_chunk(view, _packed("", 100, end, end + 100)) == plain


def test_shares_are_listed_most_frequent_first() -> None:
    chunks = [_packed("lz4", 100, 0, 10), _packed("", 5, 10, 15), _packed("none", 7, 15, 22)]
    shares = compression_shares(chunks)
    assert [(each.name, each.chunk_count) for each in shares] == [("none", 2), ("lz4", 1)]
