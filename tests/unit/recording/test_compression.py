from __future__ import annotations

import bz2
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.msgdef.registry import Registry
from rostether.recording import compression
from rostether.recording.checking import check
from rostether.recording.compression import (
    BZ2,
    LZ4,
    ZSTD,
    StoredChunk,
    check_unpacked_size,
    compress,
    compression_shares,
    decompress,
    unpack_chunk,
)
from rostether.recording.files import create_recording, open_recording
from unit.recording.bags import connection, text

STEP_BYTES = 1 << 18
SIZES = (0, 1, STEP_BYTES - 1, STEP_BYTES, 3 * STEP_BYTES + 5)


@pytest.fixture(autouse=True)
def _small_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compression, "_STEP_BYTES", STEP_BYTES)


def packed(name: str, data: bytes) -> bytes:
    if name == ZSTD:
        zstandard = pytest.importorskip("zstandard")
        return bytes(zstandard.ZstdCompressor().compress(data))
    if name == LZ4:
        pytest.importorskip("lz4.frame")
    return compress(name, data)


@pytest.mark.parametrize("name", [BZ2, LZ4, ZSTD])
@pytest.mark.parametrize("size", SIZES)
def test_a_chunk_is_unpacked_in_steps(name: str, size: int) -> None:
    data = (bytes(range(251)) * (size // 251 + 1))[:size]
    stored = packed(name, data)
    assert bytes(decompress(name, memoryview(stored), size)) == data
    for wrong in (size - 1, size + 1):
        with pytest.raises(RecordingError, match=r"bytes instead of|is broken"):
            decompress(name, stored, max(wrong, 0) if size else 1)
    if size > 100:
        with pytest.raises(RecordingError):
            decompress(name, stored[: len(stored) // 2], size)


def test_the_limit_of_the_unpacked_size() -> None:
    check_unpacked_size(compression.MAX_UNPACKED_BYTES, 1)
    check_unpacked_size(compression.MAX_RATIO * (10 << 20), 10 << 20)
    with pytest.raises(RecordingError, match="would decompress to"):
        check_unpacked_size(compression.MAX_UNPACKED_BYTES + 1, 1 << 20)


@pytest.mark.parametrize("name", ["a.bag", "a.mcap"])
@pytest.mark.parametrize("closes", [True, False])
def test_a_recording_that_would_fill_the_memory_is_refused_immediately(
    tmp_path: Path, name: str, closes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("lz4.frame")
    path = tmp_path / name
    writer = create_recording(path, compression=LZ4, chunk_bytes=1 << 20)
    number = writer.add_connection(connection("/a"))
    for index in range(8):
        writer.write(number, index, [text("x" * 1_000_000)])
    writer.close()
    if not closes:
        path.write_bytes(path.read_bytes()[:-100])
    assert sum(open_recording(path).counts.values()) == 8
    monkeypatch.setattr(compression, "MAX_UNPACKED_BYTES", 7_000_000)
    monkeypatch.setattr(compression, "MAX_RATIO", 10)
    with pytest.raises(RecordingError, match=rf"{name}.* would decompress to"):
        open_recording(path)
    with pytest.raises(RecordingError, match="would decompress to"):
        check(path, Registry())


def test_signals_are_handled_between_two_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python handles signals between two calls of a library, so no call unpacks a large chunk."""
    sizes = []
    original = bz2.BZ2Decompressor

    class Watched:
        def __init__(self) -> None:
            self._inner = original()

        @property
        def eof(self) -> bool:
            return self._inner.eof

        def decompress(self, data: bytes, max_length: int) -> bytes:
            sizes.append(max_length)
            return self._inner.decompress(data, max_length)

    size = 5 * STEP_BYTES
    stored = bz2.compress(bytes(size))
    monkeypatch.setattr(bz2, "BZ2Decompressor", Watched)
    assert len(decompress(BZ2, stored, size)) == size
    assert max(sizes) <= STEP_BYTES
    assert len(sizes) >= 5


def _stored(compression: str, size_bytes: int, start: int, end: int) -> StoredChunk:
    return StoredChunk(start, end, compression, size_bytes, 0, 0, None)


def test_a_chunk_is_unpacked() -> None:
    plain = b"ab" * 50
    stored = compress(LZ4, plain)
    view = memoryview(b"xx" + stored + plain)
    end = 2 + len(stored)
    assert unpack_chunk(view[2:end], _stored(LZ4, 100, 2, end)) == plain
    assert unpack_chunk(view[end:], _stored("", 100, end, end + 100)) == plain


def test_shares_are_listed_most_frequent_first() -> None:
    chunks = [_stored("lz4", 100, 0, 10), _stored("", 5, 10, 15), _stored("none", 7, 15, 22)]
    shares = compression_shares(chunks)
    assert [(each.name, each.chunk_count) for each in shares] == [("none", 2), ("lz4", 1)]
