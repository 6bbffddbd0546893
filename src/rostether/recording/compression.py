"""Chunks of messages in a file: compressed with bz2 or as LZ4 frames (extra `recording`), or not at all."""

from __future__ import annotations

import bz2
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

from msgspec import Struct

from rostether.errors import ConfigError, RecordingError
from rostether.extras import imported_from

Buffer: TypeAlias = bytes | memoryview

NONE = "none"
BZ2 = "bz2"
LZ4 = "lz4"
COMPRESSIONS = (NONE, BZ2, LZ4)

# Only read, in MCAP files of other programs.
ZSTD = "zstd"

# Recorders make chunks of a megabyte, or of one message when that is larger. Without a limit, a few bytes
# could unpack to any size.
MAX_CHUNK_BYTES = 256 << 20

# Up to this unpacked size of all chunks, the ratio does not matter: reading it takes seconds.
MAX_UNPACKED_BYTES = 1 << 30
# The largest ratio of unpacked size to file size, above MAX_UNPACKED_BYTES; 2 to 50 are usual.
MAX_RATIO = 1000

# Larger chunks are not copied: `chunk_order` reads them twice instead.
MAX_LISTED_BYTES = 8 << 20

# Signals are handled between steps; one step takes about 50 ms.
_STEP_BYTES = 4 << 20


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


class CompressionShare(Struct, frozen=True):
    """The chunks of a file that are compressed in one way."""

    name: str
    chunk_count: int
    size_bytes: int
    compressed_bytes: int


def check_compression(name: str) -> None:
    """Raise ConfigError if a compression is unknown or not installed."""
    if name not in COMPRESSIONS:
        raise ConfigError(f"unknown compression {name!r}; known: {', '.join(COMPRESSIONS)}")
    if name == LZ4:
        _lz4_frame()


def compress(name: str, data: bytes) -> bytes:
    """Return a chunk's data compressed. Raises ConfigError if the compression is not installed."""
    if name == BZ2:
        return bz2.compress(data)
    if name == LZ4:
        frame = _lz4_frame()
        # ROS's decoder accepts only independent blocks without a content size.
        return bytes(
            frame.compress(
                data,
                block_size=frame.BLOCKSIZE_MAX4MB,
                block_linked=False,
                content_checksum=True,
                store_size=False,
            )
        )
    return data


def decompress(name: str, data: Buffer, size_bytes: int) -> Buffer:
    """Return a chunk's data, which must have the size `size_bytes`. Raises RecordingError, ConfigError."""
    plain: Buffer
    if name in ("", NONE):
        plain = data
    elif size_bytes > MAX_CHUNK_BYTES:
        raise RecordingError(f"a chunk has a wrong size of {size_bytes} bytes")
    else:
        try:
            plain = _unpacked(name, data, size_bytes)
        except (ConfigError, RecordingError):
            raise
        except Exception:  # noqa: BLE001 - each library raises its own errors for broken data
            raise RecordingError(f"a chunk compressed with {name} is broken") from None
    if len(plain) != size_bytes:
        raise RecordingError(f"a chunk has {len(plain)} bytes instead of {size_bytes}")
    return plain


def unpack_chunk(packed: Buffer, chunk: StoredChunk) -> Buffer:
    """Return the uncompressed data of a chunk; `packed` is its data in the file.

    Raises RecordingError if it is broken, and ConfigError if its compression is not installed.
    """
    plain = decompress(chunk.compression, packed, chunk.size_bytes)
    # Slicing bytes costs half as much as slicing a view.
    return bytes(plain) if len(plain) <= MAX_LISTED_BYTES else plain


def check_unpacked_size(unpacked_bytes: int, file_bytes: int) -> None:
    """Raise RecordingError if a file's chunks unpack to an implausible size."""
    if unpacked_bytes > max(MAX_UNPACKED_BYTES, MAX_RATIO * file_bytes):
        raise RecordingError(
            f"its {file_bytes} bytes would decompress to {unpacked_bytes}, more than {MAX_RATIO} times as "
            "many; it may be an attack, so it is not read"
        )


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


def _unpacked(name: str, data: Buffer, size_bytes: int) -> Buffer:
    read = _reader(name, data)
    if size_bytes < _STEP_BYTES:
        # Reading one byte beyond the limit detects data that is too long.
        return read(size_bytes + 1)
    plain = bytearray()
    while len(plain) <= size_bytes and (part := read(_STEP_BYTES)):
        plain += part
    return memoryview(plain)


def _reader(name: str, data: Buffer) -> Callable[[int], bytes]:
    """Return a function that decompresses up to the given number of bytes; empty at the end."""
    if name == ZSTD:
        stream = zstandard_package().ZstdDecompressor().stream_reader(data)
        return lambda size: bytes(stream.read(size))
    if name not in (BZ2, LZ4):
        raise RecordingError(f"a chunk uses the unknown compression {name!r}")
    decompressor = bz2.BZ2Decompressor() if name == BZ2 else _lz4_frame().LZ4FrameDecompressor()
    rest: list[Buffer] = [data]

    def read(size: int) -> bytes:
        if decompressor.eof:
            return b""
        return bytes(decompressor.decompress(rest.pop() if rest else b"", max_length=size))

    return read


def _lz4_frame() -> Any:
    with imported_from("recording", "LZ4 is not installed"):
        import lz4.frame
    return lz4.frame


def zstandard_package() -> Any:
    """Return `zstandard`. Raises ConfigError if it is not installed."""
    with imported_from("recording", "Zstandard is not installed"):
        import zstandard
    return zstandard
