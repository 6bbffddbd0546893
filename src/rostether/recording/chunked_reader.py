"""The common part of the bag and MCAP readers: a mapped file whose messages are in chunks."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from msgspec import Struct

from rostether.errors import RecordingError
from rostether.recording.chunk_order import Entry, Unpacked, in_order
from rostether.recording.compression import (
    Buffer,
    CompressionShare,
    StoredChunk,
    compression_shares,
    unpack_chunk,
)
from rostether.recording.recorded import Connection, RecordedMessage, Wanted, wanted_connections
from rostether.recording.regular_file import MappedFile

# A text with this length gets no more reasons: every chunk may be damaged in a different way.
MAX_DAMAGE_CHARS = 500


class ChunkedContent(Struct):
    """The content of a bag or an MCAP file.

    `damage` is why the file had to be searched for its messages; empty if its index is intact. When messages
    are read, `chunks` are sorted by the times of their first messages.
    """

    damage: str = ""
    chunks: Sequence[StoredChunk] = ()

    def note(self, damage: str) -> None:
        """Add a reason why the file is damaged to the first one, up to `MAX_DAMAGE_CHARS`."""
        if damage not in self.damage and len(self.damage) < MAX_DAMAGE_CHARS:
            self.damage = f"{self.damage}; {damage}"


ContentT = TypeVar("ContentT", bound=ChunkedContent)


class ChunkedReader(Generic[ContentT]):
    """The base of the bag and MCAP readers; see `recording.recorded.RecordingReader`.

    `read` returns the content of the file; `entries_of` reads an uncompressed chunk. Subclasses set
    `_connections`. Raises RecordingError if the file cannot be read.
    """

    _connections: Mapping[int, Connection]

    def __init__(
        self,
        path: Path,
        read: Callable[[memoryview], ContentT],
        entries_of: Callable[[Buffer], Iterator[Entry]],
    ) -> None:
        self.path = path
        self._entries_of = entries_of
        self._file = MappedFile(path)
        self.size_bytes = self._file.size_bytes
        try:
            self._content = read(self._file.view)
        except RecordingError as error:
            self.close()
            raise RecordingError(f"{path}: {error}") from None

    @property
    def damage(self) -> str:
        """Why the file had to be searched for its messages, or an empty string."""
        return self._content.damage

    @property
    def chunks(self) -> Sequence[StoredChunk]:
        """The chunks, sorted by the times of their first messages."""
        return self._content.chunks

    @property
    def compressions(self) -> Sequence[CompressionShare]:
        """How the chunks are compressed, the most frequent first."""
        return compression_shares(self.chunks)

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._file.close()

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive; equal times keep the order of the file.

        Raises RecordingError at a broken chunk.
        """
        connections = wanted_connections(self._connections, wanted)

        def unpack(chunk: StoredChunk) -> Unpacked:
            plain = unpack_chunk(self._file.read(chunk.data_start, chunk.data_end), chunk)
            return plain, lambda: (entry for entry in self._entries_of(plain) if entry[3] in connections)

        needed = [
            chunk
            for chunk in self.chunks
            if (chunk.numbers is None or not connections.keys().isdisjoint(chunk.numbers))
            and (end_ns is None or chunk.start_ns <= end_ns)
            and (start_ns is None or chunk.end_ns >= start_ns)
        ]
        try:
            for number, time_ns, payload in in_order(needed, unpack, start_ns=start_ns, end_ns=end_ns):
                yield RecordedMessage(connections[number], time_ns, payload)
        except RecordingError as error:
            raise RecordingError(f"{self.path}: {error}; `rostether bag reindex` keeps the rest") from None


class Tally(NamedTuple):
    """The messages of a chunk by connection number, and the times of the first and the last one."""

    counts: dict[int, int]
    first_ns: int
    last_ns: int


def tally(entries: Iterable[Entry], defined: Container[int], note: Callable[[str], None], noun: str) -> Tally:
    """Count messages; messages of a connection or channel (`noun`) that is not defined are only reported."""
    counts: dict[int, int] = {}
    first_ns, last_ns = 1 << 64, -1
    for time_ns, _, _, number in entries:
        if number not in defined:
            note(f"messages belong to {noun} {number}, which is not defined")
            continue
        counts[number] = counts.get(number, 0) + 1
        first_ns = min(first_ns, time_ns)
        last_ns = max(last_ns, time_ns)
    return Tally(counts, first_ns, last_ns)
