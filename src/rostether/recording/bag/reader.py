"""Reads ROS 1 bags, format 2.0, from any program, closed or not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

from rostether.recording.bag.chunks import BagContent, messages_in
from rostether.recording.bag.content import read_content
from rostether.recording.chunked_reader import ChunkedReader
from rostether.recording.recorded import Connection, RecordedMessage, Wanted, wanted_connections


class BagReader(ChunkedReader[BagContent]):
    """A bag being read; see `recording.recorded.RecordingReader`.

    Raises RecordingError if the file is not a bag. `damage`, if given, is the reason not to use its index.
    """

    format_version = "2.0"
    unreadable: Mapping[str, str] = MappingProxyType({})

    def __init__(self, path: Path, *, damage: str = "") -> None:
        super().__init__(path, lambda view: read_content(view, damage))
        self._content.chunks.sort(key=lambda chunk: chunk.start_ns)

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

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive; equal times keep the order of the file.

        Raises RecordingError at a broken chunk.
        """
        connections = wanted_connections(self._content.connections, wanted)
        return self._messages(connections, messages_in, start_ns, end_ns)
