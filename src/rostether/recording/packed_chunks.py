"""Chunks as stored in a file, compressed or not: their contents, and how much compression saves."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct

from rostether.recording.compression import NONE, Buffer, decompress
from rostether.recording.recorded import CompressionShare

# Larger chunks are not copied: `chunk_order` reads them twice instead.
MAX_LISTED_BYTES = 8 << 20


class StoredChunk(Struct, frozen=True):
    """The position of a chunk's data in its file, its uncompressed size, and the times of its messages.

    `compression` is empty or "none" without compression. `numbers` are the connections or channels that have
    messages in it, None if unknown.
    """

    data_start: int
    data_end: int
    compression: str
    size_bytes: int
    start_ns: int
    end_ns: int
    numbers: frozenset[int] | None


def unpack_chunk(view: memoryview, chunk: StoredChunk) -> Buffer:
    """Return the uncompressed data of a chunk of the file `view`.

    Raises RecordingError if it is broken, and ConfigError if its compression is not installed.
    """
    plain = decompress(chunk.compression, view[chunk.data_start : chunk.data_end], chunk.size_bytes)
    # Slicing bytes costs half as much as slicing a view.
    return bytes(plain) if len(plain) <= MAX_LISTED_BYTES else plain


def compression_shares(chunks: Iterable[StoredChunk]) -> list[CompressionShare]:
    """Return how chunks are compressed, the most frequent first."""
    by_name: dict[str, list[StoredChunk]] = {}
    for chunk in chunks:
        by_name.setdefault(chunk.compression or NONE, []).append(chunk)
    shares = (
        CompressionShare(
            name,
            len(packed),
            sum(each.size_bytes for each in packed),
            sum(each.data_end - each.data_start for each in packed),
        )
        for name, packed in by_name.items()
    )
    return sorted(shares, key=lambda share: -share.chunk_count)
