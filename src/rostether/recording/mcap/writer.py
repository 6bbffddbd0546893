"""Writes MCAP files with ROS 1 messages (profile `ros1`, schemas `ros1msg`): chunks with their indexes.

Source: mcap.dev/spec
"""

from __future__ import annotations

import sys
import zlib
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from rostether.errors import ConfigError, RecordingError
from rostether.recording.chunked_writer import DEFAULT_CHUNK_BYTES, ChunkedWriter
from rostether.recording.compression import BZ2, NONE
from rostether.recording.mcap.records import (
    CHUNK_HEAD,
    FOOTER,
    MAGIC,
    MESSAGE_HEAD,
    RECORD_HEAD,
    SUMMARY_OFFSET,
    U16,
    U16_PAIR,
    U32,
    U64,
    U64_PAIR,
    ChunkIndex,
    Op,
    Statistics,
    encode_chunk_index,
    encode_map,
    encode_record,
    encode_statistics,
    encode_text,
)
from rostether.recording.recorded import Connection

# A channel's number has two bytes.
MAX_CHANNELS = 0xFFFF

_MAX_TIME_NS = (1 << 64) - 1


class McapWriter(ChunkedWriter):
    """An MCAP file being written; see `recording.recorded.RecordingWriter`.

    Subclasses for another ROS version override `profile`, `schema_of` and `channel_of`. Raises
    RecordingError, and ConfigError if the compression is not installed, or MCAP does not have it.
    """

    profile = "ros1"
    _index_code = "Q"

    def __init__(
        self, path: Path, *, compression: str = NONE, chunk_bytes: int = DEFAULT_CHUNK_BYTES
    ) -> None:
        if compression == BZ2:
            raise ConfigError("MCAP does not support bz2; use lz4, or no compression")
        self._numbers: dict[Connection, int] = {}
        # The number and the record of each schema.
        self._schemas: dict[tuple[str, str, bytes], tuple[int, bytes]] = {}
        # The records of the schema and the channel of each connection.
        self._channels: dict[int, tuple[bytes, bytes]] = {}
        # The records of schemas and channels that are in the file, and those that are in the open chunk.
        self._known: set[bytes] = set()
        self._written: set[bytes] = set()
        self._indexes: list[ChunkIndex] = []
        self._counts: dict[int, int] = {}
        self._data_crc = 0
        header = encode_text(self.profile) + encode_text("rostether")
        super().__init__(path, compression, chunk_bytes, MAGIC + encode_record(Op.HEADER, header))

    def schema_of(self, connection: Connection) -> tuple[str, str, bytes]:
        """Return name, encoding and definition of a connection's type."""
        definition = connection.type.definition.encode("utf-8", "surrogateescape")
        return connection.type.name, "ros1msg", definition

    def channel_of(self, connection: Connection) -> tuple[str, Mapping[str, str]]:
        """Return how a connection's messages are encoded, and its metadata."""
        elsewhere = ("message_definition", "topic", "type")
        return "ros1", {key: value for key, value in connection.fields().items() if key not in elsewhere}

    def add_connection(self, connection: Connection) -> int:
        """Add a connection if it is new; return its number. Raises RecordingError beyond 65535."""
        number = self._numbers.get(connection)
        if number is None:
            number = len(self._numbers) + 1
            if number > MAX_CHANNELS:
                raise RecordingError(f"MCAP can have at most {MAX_CHANNELS} connections; record a .bag file")
            key = self.schema_of(connection)
            if key not in self._schemas:
                schema = len(self._schemas) + 1
                parts = (U16.pack(schema), *(encode_text(each) for each in key))
                self._schemas[key] = (schema, encode_record(Op.SCHEMA, b"".join(parts)))
            schema, schema_record = self._schemas[key]
            encoding, metadata = self.channel_of(connection)
            head = U16_PAIR.pack(number, schema) + encode_text(connection.topic) + encode_text(encoding)
            self._channels[number] = (schema_record, encode_record(Op.CHANNEL, head + encode_map(metadata)))
            self._numbers[connection] = number
        return number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at the same time. Raises RecordingError if the disk rejects them."""
        super().write(number, min(max(time_ns, 0), _MAX_TIME_NS), payloads)

    def _write_chunk(self, plain: bytes, stored: bytes, start_ns: int) -> None:
        name = "" if self._compression == NONE else self._compression
        head = CHUNK_HEAD.pack(start_ns, self._end_ns, len(plain), zlib.crc32(plain))
        content = b"".join((head, encode_text(name), U64.pack(len(stored)), stored))
        record = encode_record(Op.CHUNK, content)
        position = self._file.position
        offset = position + len(record)
        index_offsets: dict[int, int] = {}
        indexes = []
        for number, entries in self._index.items():
            index_offsets[number] = offset
            indexes.append(_index_record(number, entries))
            offset += len(indexes[-1])
        counts = {number: len(entries) // 2 for number, entries in self._index.items()}
        index = ChunkIndex(
            position=position,
            length=len(record),
            start_ns=start_ns,
            end_ns=self._end_ns,
            indexes=index_offsets,
            indexes_bytes=offset - position - len(record),
            compression=name,
            compressed_bytes=len(stored),
            size_bytes=len(plain),
        )
        written, self._written = self._written, set()
        self._append_chunk(b"".join((record, *indexes)), sum(counts.values()))
        self._known |= written
        self._indexes.append(index)
        for number, count in counts.items():
            self._counts[number] = self._counts.get(number, 0) + count

    def _pop_unwritten(self, number: int) -> Iterable[bytes]:
        records = self._channels[number]
        missing = [each for each in records if each not in self._known and each not in self._written]
        self._written.update(missing)
        return missing

    def _message_form(self, number: int, time_ns: int) -> tuple[tuple[int, ...], Callable[[int], bytes]]:
        # No sequence number (0): all headers of a batch are then equal, and the order in the file is enough.
        inner = MESSAGE_HEAD.pack(number, 0, time_ns, time_ns)
        return (time_ns,), lambda size: RECORD_HEAD.pack(Op.MESSAGE, len(inner) + size) + inner

    def _append(self, data: bytes) -> None:
        self._file.append(data)
        self._data_crc = zlib.crc32(data, self._data_crc)

    def _write_end(self) -> None:
        for number in self._channels:
            for record in self._pop_unwritten(number):  # Its topic has no messages.
                self._append(record)
                self._known.add(record)
        data_end = encode_record(Op.DATA_END, U32.pack(self._data_crc))
        start = self._file.position + len(data_end)
        groups = (
            (Op.SCHEMA, [record for _, record in self._schemas.values()]),
            (Op.CHANNEL, [record for _, record in self._channels.values()]),
            (Op.STATISTICS, [encode_statistics(self._statistics())]),
            (Op.CHUNK_INDEX, [encode_chunk_index(each) for each in self._indexes]),
        )
        parts: list[bytes] = []
        offsets: list[bytes] = []
        position = start
        for op, records in groups:
            length = sum(map(len, records))
            if records:
                parts += records
                offsets.append(encode_record(Op.SUMMARY_OFFSET, SUMMARY_OFFSET.pack(op, position, length)))
                position += length
        parts += offsets
        parts.append(RECORD_HEAD.pack(Op.FOOTER, FOOTER.size) + U64_PAIR.pack(start, position))
        summary = b"".join(parts)
        self._file.append(data_end + summary + U32.pack(zlib.crc32(summary)) + MAGIC)

    def _statistics(self) -> Statistics:
        return Statistics(
            message_count=sum(self._counts.values()),
            schema_count=len(self._schemas),
            channel_count=len(self._channels),
            attachment_count=0,
            metadata_count=0,
            chunk_count=len(self._indexes),
            start_ns=min((each.start_ns for each in self._indexes), default=0),
            end_ns=max((each.end_ns for each in self._indexes), default=0),
            counts=self._counts,
        )


def _index_record(number: int, entries: array[int]) -> bytes:
    if sys.byteorder == "big":
        entries.byteswap()
    return encode_record(Op.MESSAGE_INDEX, U16.pack(number) + encode_text(entries.tobytes()))
