"""Reads ROS 1 bags, format 2.0, of any writer, closed or not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from rostether.errors import RecordingError
from rostether.recording.bag.chunks import messages_in
from rostether.recording.bag.content import read_content
from rostether.recording.bag.records import MAGIC, MAGIC_START
from rostether.recording.chunk_order import messages_of
from rostether.recording.packed_chunks import compression_shares
from rostether.recording.recorded import (
    CompressionShare,
    Connection,
    RecordedMessage,
    Wanted,
    wanted_connections,
)
from rostether.recording.regular_file import MappedFile


class BagReader:
    """A bag being read; see `recording.recorded.RecordingReader`.

    Raises RecordingError if the file is not a bag. `damage`, if given, is the reason not to use its index.
    """

    format_version = "2.0"
    unreadable: Mapping[str, str] = MappingProxyType({})

    def __init__(self, path: Path, *, damage: str = "") -> None:
        self.path = path
        self._file = MappedFile(path)
        self.size_bytes = self._file.size_bytes
        self._view = self._file.view
        try:
            start = bytes(self._view[: len(MAGIC)])
            if start != MAGIC:
                raise RecordingError(f"{path} {_what_else(start)}")
            try:
                self._content = read_content(self._view, damage)
            except RecordingError as error:
                raise RecordingError(f"{path}: {error}") from None
        except BaseException:
            self.close()
            raise
        self._content.chunks.sort(key=lambda chunk: chunk.start_ns)

    @property
    def damage(self) -> str:
        """Why the file had to be searched for its messages, or an empty string."""
        return self._content.damage

    @property
    def connections(self) -> Mapping[int, Connection]:
        """The connections by their numbers in the file."""
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
        return compression_shares(self._content.chunks)

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive; equal times keep the order of the file.

        Raises RecordingError at a broken chunk.
        """
        connections = wanted_connections(self._content.connections, wanted)
        found = messages_of(
            self._view,
            self._content.chunks,
            connections.keys(),
            messages_in,
            start_ns=start_ns,
            end_ns=end_ns,
        )
        try:
            for number, time_ns, payload in found:
                yield RecordedMessage(connections[number], time_ns, payload)
        except RecordingError as error:
            raise RecordingError(f"{self.path}: {error}; `rostether bag reindex` keeps the rest") from None

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._file.close()


def _what_else(start: bytes) -> str:
    if MAGIC.startswith(start):
        return f"is truncated: it has only {len(start)} bytes"
    if start.startswith(MAGIC_START):
        version = start[len(MAGIC_START) :].decode("latin-1").split("\n")[0]
        version = version.strip().encode("unicode_escape").decode()
        return f"is a bag of format {version}; only 2.0 can be read"
    return "is not a bag: bags start with '#ROSBAG V2.0'"
