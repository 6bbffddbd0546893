"""Chunks as stored in a file, compressed or not: their contents, and how much compression saves."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from rostether.recording.chunk_order import MAX_LISTED_BYTES
from rostether.recording.compression import NONE, decompress
from rostether.recording.recorded import CompressionShare


class PackedChunk(Protocol):
    """The position and the compression of a chunk's data in its file."""

    @property
    def compression(self) -> str:
        """The compression's name; empty or "none" without compression."""

    @property
    def size_bytes(self) -> int:
        """Its uncompressed size."""

    @property
    def data_start(self) -> int:
        """The position of its data in the file."""

    @property
    def data_end(self) -> int:
        """The end of its data in the file."""


def unpack_chunk(view: memoryview, chunk: PackedChunk) -> bytes | memoryview:
    """Return the data of a chunk. Raises RecordingError if it is broken."""
    plain = decompress(chunk.compression, view[chunk.data_start : chunk.data_end], chunk.size_bytes)
    # Slicing bytes costs half as much as slicing a view.
    return bytes(plain) if len(plain) <= MAX_LISTED_BYTES else plain


def compression_shares(chunks: Iterable[PackedChunk]) -> list[CompressionShare]:
    """Return how chunks are compressed, the most frequent first."""
    by_name: dict[str, list[PackedChunk]] = {}
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
