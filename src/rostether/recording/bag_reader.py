"""Reads ROS 1 bags, format 2.0, whoever wrote them, closed or not."""

from __future__ import annotations

import contextlib
import mmap
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType

from rostether.errors import RecordingError
from rostether.recording.bag_chunks import Chunk, messages_in, read_content
from rostether.recording.bag_records import MAGIC, MAGIC_START
from rostether.recording.chunk_order import MAX_LISTED_BYTES, Entry, Unpacked, in_order
from rostether.recording.compression import decompress
from rostether.recording.recorded import CompressionShare, Connection, RecordedMessage, Wanted


class BagReader:
    """A bag being read; see `recording.recorded.RecordingReader`. Raises RecordingError when it is none.

    With `damage`, which is then why, its index is not trusted.
    """

    format_version = "2.0"
    unreadable: Mapping[str, str] = MappingProxyType({})

    def __init__(self, path: Path, *, damage: str = "") -> None:
        self.path = path
        try:
            descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
            try:
                self.size_bytes = os.fstat(descriptor).st_size
                start = os.read(descriptor, len(MAGIC))
                if start != MAGIC:
                    raise RecordingError(f"{path} {_what_else(start)}")
                self._data = mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
            finally:
                os.close(descriptor)
        except OSError as error:
            raise RecordingError(f"cannot read {path}: {error.strerror or error}") from None
        self._view = memoryview(self._data)
        try:
            self._content = read_content(self._view, damage)
        except BaseException:
            self.close()
            raise
        self._content.chunks.sort(key=lambda chunk: chunk.start_ns)

    @property
    def damage(self) -> str:
        """Why the file had to be searched for its messages, or an empty string."""
        return self._content.damage

    @property
    def whole_bytes(self) -> int:
        """How far the file is whole."""
        return self._content.whole_bytes

    @property
    def connections(self) -> Mapping[int, Connection]:
        """The connections by the number they have in the file."""
        return self._content.connections

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        counts: Counter[Connection] = Counter(dict.fromkeys(self._content.connections.values(), 0))
        for chunk in self._content.chunks:
            for number, count in chunk.counts.items():
                counts[self._content.connections[number]] += count
        return counts

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message; None in an empty bag."""
        chunks = self._content.chunks
        return (chunks[0].start_ns, max(chunk.end_ns for chunk in chunks)) if chunks else None

    @property
    def compressions(self) -> Sequence[CompressionShare]:
        """How the chunks are compressed, the most frequent first."""
        by_name: dict[str, list[Chunk]] = {}
        for chunk in self._content.chunks:
            by_name.setdefault(chunk.compression, []).append(chunk)
        shares = (
            CompressionShare(
                name,
                len(chunks),
                sum(chunk.size_bytes for chunk in chunks),
                sum(chunk.data_end - chunk.data_start for chunk in chunks),
            )
            for name, chunks in by_name.items()
        )
        return sorted(shares, key=lambda share: -share.chunk_count)

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages in the order of their times, both ends included; equal times as in the file.

        Raises RecordingError at a chunk that is broken.
        """
        connections = {
            number: connection
            for number, connection in self._content.connections.items()
            if wanted is None or wanted(connection)
        }
        chunks = [
            chunk
            for chunk in self._content.chunks
            if not connections.keys().isdisjoint(chunk.counts)
            and (end_ns is None or chunk.start_ns <= end_ns)
            and (start_ns is None or chunk.end_ns >= start_ns)
        ]
        found = in_order(chunks, partial(self._unpack, connections), start_ns=start_ns, end_ns=end_ns)
        try:
            for number, time_ns, payload in found:
                yield RecordedMessage(connections[number], time_ns, payload)
        except RecordingError as error:
            raise RecordingError(
                f"{self.path}: {error}; `rostether bag reindex` keeps what is whole before it"
            ) from None

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._view.release()
        with contextlib.suppress(BufferError):  # a reading that was left holds a part of it, and frees it
            self._data.close()

    def _unpack(self, connections: Mapping[int, Connection], chunk: Chunk) -> Unpacked:
        stored = self._view[chunk.data_start : chunk.data_end]
        plain = decompress(chunk.compression, stored, chunk.size_bytes)
        if len(plain) <= MAX_LISTED_BYTES:
            plain = bytes(plain)  # a slice of bytes costs half of what one of a view does

        def walk() -> Iterator[Entry]:
            for number, time_ns, start, end in messages_in(plain):
                if number in connections:
                    yield time_ns, start, end, number

        return plain, walk


def _what_else(start: bytes) -> str:
    if not start:
        return "is empty"
    if start.startswith(MAGIC_START):
        version = start[len(MAGIC_START) :].decode("latin-1").split("\n")[0]
        version = version.strip().encode("unicode_escape").decode()
        return f"is a bag of format {version}; only 2.0 can be read"
    return "is no bag: bags begin with '#ROSBAG V2.0'"
