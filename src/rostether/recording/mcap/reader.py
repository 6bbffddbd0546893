"""Reads MCAP files with messages of ROS 1 or ROS 2, from any program: by their summary, or by a search.

Source: mcap.dev/spec
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rostether.errors import RecordingError
from rostether.mechanisms.text import counted
from rostether.recording.chunked_reader import ChunkedReader
from rostether.recording.compression import MAX_CHUNK_BYTES, Buffer, StoredChunk, check_unpacked_size
from rostether.recording.mcap.content import McapContent, messages_in, search
from rostether.recording.mcap.records import (
    FOOTER_BYTES,
    MAGIC,
    U32,
    Channel,
    ChunkIndex,
    Op,
    Schema,
    Statistics,
    check_header,
    decode_chunk,
    decode_chunk_index,
    decode_footer,
    decode_statistics,
    read_record,
)
from rostether.recording.recorded import Connection, RecordedMessage, Ros2Origin, Wanted

if TYPE_CHECKING:
    from rostether.recording.ros2_types import RecordedTopics

_ENCODING = "ros1"


class McapReader(ChunkedReader[McapContent]):
    """An MCAP file being read; see `recording.recorded.RecordingReader`.

    Only ROS 1 and CDR messages are returned; CDR is converted to ROS 1 bytes, with the fields of ROS 2 if
    `is_native`. `unpack` decompresses messages that a ROS 2 bag compresses one by one. `damage`, if given, is
    the reason not to use the index. A missing md5sum of a type is computed from the definition. Raises
    RecordingError if the file is not MCAP.
    """

    def __init__(
        self,
        path: Path,
        *,
        is_native: bool = False,
        unpack: Callable[[bytes], bytes] | None = None,
        damage: str = "",
    ) -> None:
        super().__init__(path, lambda view: read_content(view, damage), messages_in)
        self._unpack_message = unpack
        self._is_native = is_native
        self._ros2: RecordedTopics | None = None
        self._connections: dict[int, Connection] = {}
        for number, channel in self._content.channels.items():
            connection = self._connection(self._content.schemas.get(channel.schema), channel)
            if connection is not None:
                self._connections[number] = connection

    @property
    def format_version(self) -> str:
        """The format's name, with "ROS 2" if it has ROS 2 messages."""
        return "MCAP" if self._ros2 is None else "MCAP (ROS 2)"

    @property
    def unreadable(self) -> Mapping[str, str]:
        """Topics with messages that cannot be converted, and why."""
        return {} if self._ros2 is None else self._ros2.unreadable

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        counts: Counter[Connection] = Counter()
        for number, connection in self._connections.items():
            counts[connection] += self._content.counts.get(number, 0)
        return counts

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message; None in an empty file."""
        return self._content.span_ns

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive. Raises RecordingError."""
        found = super().messages(wanted, start_ns=start_ns, end_ns=end_ns)
        return found if self._ros2 is None else self._converted(self._ros2, found)

    def _converted(
        self, topics: RecordedTopics, found: Iterator[RecordedMessage]
    ) -> Iterator[RecordedMessage]:
        for message in found:
            connection, time_ns, payload = message
            if connection.origin is None:
                yield message
                continue
            cdr = payload if self._unpack_message is None else self._unpack_message(payload)
            converted = topics.convert(connection, cdr)
            if converted is not None:
                yield RecordedMessage(connection, time_ns, converted)

    def _connection(self, schema: Schema | None, channel: Channel) -> Connection | None:
        """Return a channel as a connection; None if its messages cannot be converted."""
        name = schema.name if schema is not None else "*"
        if channel.encoding == "cdr" and schema is not None:
            return self._ros2_connection(schema, channel)
        if channel.encoding != _ENCODING:
            return None
        definition = schema.data.decode("utf-8", "surrogateescape") if schema is not None else ""
        md5sum = channel.metadata.get("md5sum") or _md5sum(name, definition)
        fields = {"type": name, "md5sum": md5sum, "message_definition": definition}
        if channel.metadata.get("latching") == "true":
            fields["latching"] = "1"
        return Connection.from_fields(channel.topic, {**channel.metadata, **fields})

    def _ros2_connection(self, schema: Schema, channel: Channel) -> Connection | None:
        if self._ros2 is None:
            from rostether.recording.ros2_types import RecordedTopics

            self._ros2 = RecordedTopics(is_native=self._is_native)
        origin = Ros2Origin(
            schema.name,
            channel.metadata.get("topic_type_hash", ""),
            schema.encoding,
            schema.data.decode("utf-8", "surrogateescape"),
        )
        return self._ros2.connection(channel.topic, origin, channel.metadata.get("offered_qos_profiles"))


def read_content(data: Buffer, damage: str = "") -> McapContent:
    """Return the content of a file, by its summary, or by a search if the summary is missing or damaged.

    `damage`, if given, is the reason not to use the summary. Raises RecordingError if the file is not MCAP.
    """
    begin = bytes(data[: len(MAGIC)])
    if begin != MAGIC:
        if MAGIC.startswith(begin):
            raise RecordingError(f"it is truncated: it has only {counted(len(begin), 'byte')}")
        if begin.startswith(MAGIC[:5]):
            raise RecordingError("it has an unsupported MCAP version; only version 0 can be read")
        raise RecordingError("it is not an MCAP file: those start with '\\x89MCAP0'")
    if damage:
        return search(data, damage)
    try:
        return _by_summary(data)
    except RecordingError as error:
        return search(data, str(error))


def footer_of(data: Buffer) -> tuple[int, int, int]:
    """Return the positions of summary and summary offsets, and their checksum.

    Raises RecordingError if the file was not closed.
    """
    start = len(data) - len(MAGIC) - FOOTER_BYTES
    if start < len(MAGIC) or bytes(data[-len(MAGIC) :]) != MAGIC:
        raise RecordingError("it was not closed")
    op, content, end = read_record(data, start)
    if op != Op.FOOTER:
        raise RecordingError("it ends without a footer")
    return decode_footer(data, content, end)


def has_damaged_summary(data: Buffer, position: int, checksum: int) -> bool:
    """Return whether the summary at a position differs from its checksum; 0 is no checksum."""
    return checksum != 0 and zlib.crc32(data[position : len(data) - len(MAGIC) - U32.size]) != checksum


def _summary_position(data: Buffer) -> int:
    op, start, end = read_record(data, len(MAGIC))
    if op != Op.HEADER:
        raise RecordingError("it does not start with a header")
    check_header(data, start, end)
    position, _, checksum = footer_of(data)
    if position == 0:
        raise RecordingError("it has no index")
    if has_damaged_summary(data, position, checksum):
        raise RecordingError("the checksum (CRC) of its index is wrong")
    return position


def _by_summary(data: Buffer) -> McapContent:
    content = McapContent()
    position = _summary_position(data)
    statistics: Statistics | None = None
    indexes: list[ChunkIndex] = []
    summary_end = len(data) - len(MAGIC) - FOOTER_BYTES
    while position < summary_end:
        op, start, position = read_record(data, position, summary_end)
        if op in (Op.SCHEMA, Op.CHANNEL):
            content.define(op, data, start, position)
        elif op == Op.STATISTICS:
            statistics = decode_statistics(data, start, position)
        elif op == Op.CHUNK_INDEX:
            indexes.append(decode_chunk_index(data, start, position))
    if statistics is None:
        raise RecordingError("it has no statistics")
    if len(indexes) != statistics.chunk_count:
        raise RecordingError(f"its index lists {len(indexes)} of {statistics.chunk_count} chunks")
    if statistics.message_count and not indexes:
        raise RecordingError("its messages are not in chunks and have no index")
    unknown = statistics.counts.keys() - content.channels.keys()
    if unknown:
        raise RecordingError(f"its index does not list channel {min(unknown)}")
    content.chunks = sorted((_indexed(data, each) for each in indexes), key=lambda chunk: chunk.start_ns)
    packed = (each.size_bytes for each in content.chunks if each.compression)
    check_unpacked_size(sum(min(each, MAX_CHUNK_BYTES) for each in packed), len(data))
    content.counts = dict(statistics.counts)
    if statistics.message_count:
        content.span_ns = (statistics.start_ns, statistics.end_ns)
    return content


def _indexed(data: Buffer, index: ChunkIndex) -> StoredChunk:
    if index.position > len(data):
        raise RecordingError("its index lists a chunk after the end of the file")
    op, start, end = read_record(data, index.position)
    if op != Op.CHUNK:
        raise RecordingError("there is no chunk at a position in its index")
    return replace(decode_chunk(data, start, end), numbers=frozenset(index.indexes) or None)


def _md5sum(name: str, definition: str) -> str:
    from rostether.errors import RostetherError
    from rostether.msgdef.registry import Registry

    try:
        return Registry.of_full_text(name, definition).message_type(name).md5sum
    except RostetherError:
        return "*"
