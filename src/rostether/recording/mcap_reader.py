"""Reads MCAP files with ROS 1 messages through the package `mcap`. Source: mcap.dev/spec"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from rostether.errors import ConfigError, RecordingError
from rostether.msgdef.interface import MessageType
from rostether.recording.recorded import CompressionShare, Connection, RecordedMessage, Wanted

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

_ENCODING = "ros1"


class McapReader:
    """An MCAP file being read; see `recording.recorded.RecordingReader`. Only messages of ROS 1 are given.

    Where it has no md5sum of a type, that is computed from the definition.
    """

    def __init__(self, path: Path) -> None:
        try:
            from mcap.exceptions import McapError
            from mcap.reader import NonSeekingReader, SeekingReader
        except ImportError:
            raise ConfigError("MCAP is not installed; type: pip install 'rostether[recording]'") from None
        self.path = path
        self.damage = ""
        # What the package raises at bytes that it does not expect.
        self._broken: tuple[type[Exception], ...] = (
            *(McapError, struct.error, EOFError, ValueError, LookupError, RuntimeError, OSError),
        )
        self._connections: dict[int, Connection] = {}
        self.format_version = "MCAP"
        self._compressions: Sequence[CompressionShare] = ()
        self._file: IO[bytes]
        try:
            self.size_bytes = path.stat().st_size
            self._file = path.open("rb")
        except OSError as error:
            raise RecordingError(f"cannot read {path}: {error.strerror or error}") from None
        self._open_stream: Callable[[], Any] = lambda: NonSeekingReader(self._file)
        self._reader: Any = SeekingReader(self._file)
        try:
            summary = self._reader.get_summary()
        except self._broken as error:
            summary = None
            self.damage = f"it was not closed ({error or type(error).__name__})"
        if summary is None or summary.statistics is None:
            self.damage = self.damage or "it has no index"
            self._count_all()
        else:
            self._counts = Counter(
                {
                    self._connection(summary.schemas.get(channel.schema_id), channel): 0
                    for channel in summary.channels.values()
                    if channel.message_encoding == _ENCODING
                }
            )
            for number, count in summary.statistics.channel_message_counts.items():
                if number in self._connections:
                    self._counts[self._connections[number]] += count
            statistics = summary.statistics
            self.span_ns: tuple[int, int] | None = (
                (statistics.message_start_time, statistics.message_end_time)
                if statistics.message_count
                else None
            )
            self._compressions = _shares(summary.chunk_indexes)

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        return self._counts

    @property
    def compressions(self) -> Sequence[CompressionShare]:
        """How the chunks are compressed, the most frequent first."""
        return self._compressions

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages in the order of their times, both ends included. Raises RecordingError."""
        if self.damage:
            yield from sorted(self._found(wanted, start_ns, end_ns), key=lambda message: message.time_ns)
            return
        found = self._reader.iter_messages(starting_at=start_ns, ending_at=end_ns)
        try:
            yield from self._given(found, wanted)
        except self._broken as error:
            raise RecordingError(f"{self.path}: {error or type(error).__name__}") from None

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._file.close()

    def _given(self, found: Any, wanted: Wanted | None) -> Iterator[RecordedMessage]:
        for schema, channel, message in found:
            connection = self._connections.get(channel.id)
            if connection is None:
                if channel.message_encoding != _ENCODING:
                    continue
                connection = self._connection(schema, channel)
            if wanted is None or wanted(connection):
                yield RecordedMessage(connection, message.log_time, message.data)

    def _found(
        self, wanted: Wanted | None, start_ns: int | None, end_ns: int | None
    ) -> Iterator[RecordedMessage]:
        """Yield what is whole in a file without its end, as it stands there."""
        self._file.seek(0)
        found = self._open_stream().iter_messages(log_time_order=False)
        try:
            for message in self._given(found, wanted):
                if (start_ns or 0) <= message.time_ns and (end_ns is None or message.time_ns <= end_ns):
                    yield message
        except self._broken:
            return

    def _count_all(self) -> None:
        self._counts = Counter()
        times: list[int] = []
        for message in self._found(None, None, None):
            self._counts[message.connection] += 1
            times.append(message.time_ns)
        self.span_ns = (min(times), max(times)) if times else None

    def _connection(self, schema: Schema | None, channel: Channel) -> Connection:
        name = schema.name if schema is not None else "*"
        definition = schema.data.decode("utf-8", "surrogateescape") if schema is not None else ""
        md5sum = channel.metadata.get("md5sum") or _md5sum(name, definition)
        connection = Connection(
            channel.topic,
            MessageType(name, md5sum, definition),
            channel.metadata.get("callerid", ""),
            channel.metadata.get("latching", "") in ("1", "true"),
        )
        self._connections[channel.id] = connection
        return connection


def _md5sum(name: str, definition: str) -> str:
    from rostether.errors import RostetherError
    from rostether.msgdef.registry import Registry

    try:
        registry = Registry(bundled=False)
        registry.add_full_text(name, definition)
        return registry.message_type(name).md5sum
    except RostetherError:
        return "*"


def _shares(chunk_indexes: Sequence[Any]) -> Sequence[CompressionShare]:
    by_name: dict[str, list[Any]] = {}
    for each in chunk_indexes:
        by_name.setdefault(each.compression or "none", []).append(each)
    shares = (
        CompressionShare(
            name,
            len(chunks),
            sum(each.uncompressed_size for each in chunks),
            sum(each.compressed_size for each in chunks),
        )
        for name, chunks in by_name.items()
    )
    return sorted(shares, key=lambda share: -share.chunk_count)
