"""Decodes the records of MCAP files, and checks all lengths.

The decode functions raise RecordingError if a record is shorter than its content.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from rostether.errors import RecordingError
from rostether.recording.compression import Buffer
from rostether.recording.mcap.records import (
    CHANNEL_AND_NUMBER,
    CHUNK_HEAD,
    CHUNK_LOCATION,
    FOOTER,
    KINDS,
    RECORD_HEAD,
    STATISTICS,
    U16,
    U16_PAIR,
    U32,
    U64,
    U64_PAIR,
    Channel,
    Chunk,
    ChunkIndex,
    Schema,
    Statistics,
)


def read_record(data: Buffer, position: int, end: int | None = None) -> tuple[int, int, int]:
    """Return a record's kind, and start and end of its content. Raises RecordingError if it is truncated."""
    end = len(data) if end is None else end
    start = position + RECORD_HEAD.size
    if start > end:
        raise RecordingError("it ends within a record")
    op, length = RECORD_HEAD.unpack_from(data, position)
    if length > end - start:
        raise RecordingError(f"it ends within a record ({KINDS.get(op, hex(op))})")
    return op, start, start + length


class _Fields:
    """Reads the fields of a record one after the other. Raises RecordingError if they do not fit."""

    def __init__(self, data: Buffer, start: int, end: int, kind: str) -> None:
        self._data = data
        self.position = start
        self.end = end
        self._kind = kind

    def unpack(self, form: struct.Struct) -> tuple[int, ...]:
        position = self._advance(form.size)
        return form.unpack_from(self._data, position)

    def data(self) -> bytes:
        length = self.unpack(U32)[0]
        position = self._advance(length)
        return bytes(self._data[position : position + length])

    def text(self) -> str:
        return self.data().decode("utf-8", "surrogateescape")

    def part(self, form: struct.Struct = U32) -> _Fields:
        """Read a length and the fields after it."""
        length = self.unpack(form)[0]
        position = self._advance(length)
        return _Fields(self._data, position, position + length, self._kind)

    def texts(self) -> dict[str, str]:
        fields = self.part()
        values: dict[str, str] = {}
        while fields.position < fields.end:
            key = fields.text()
            values[key] = fields.text()
        return values

    def numbers(self) -> dict[int, int]:
        fields = self.part()
        values: dict[int, int] = {}
        while fields.position < fields.end:
            key, value = fields.unpack(CHANNEL_AND_NUMBER)
            values[key] = value
        return values

    def _advance(self, length: int) -> int:
        position = self.position
        if length > self.end - position:
            raise RecordingError(f"a record ({self._kind}) is shorter than its content")
        self.position = position + length
        return position


def check_header(data: Buffer, start: int, end: int) -> None:
    """Raise RecordingError if the header's profile or library is cut off."""
    fields = _Fields(data, start, end, "header")
    fields.text()
    fields.text()


def decode_schema(data: Buffer, start: int, end: int) -> Schema:
    """Return a schema."""
    fields = _Fields(data, start, end, "schema")
    return Schema(fields.unpack(U16)[0], fields.text(), fields.text(), fields.data())


def decode_channel(data: Buffer, start: int, end: int) -> Channel:
    """Return a channel."""
    fields = _Fields(data, start, end, "channel")
    number, schema = fields.unpack(U16_PAIR)
    return Channel(number, schema, fields.text(), fields.text(), fields.texts())


def decode_chunk(data: Buffer, start: int, end: int) -> Chunk:
    """Return a chunk."""
    fields = _Fields(data, start, end, "chunk")
    start_ns, end_ns, size_bytes, crc = fields.unpack(CHUNK_HEAD)
    compression = fields.text()
    stored = fields.part(U64)
    return Chunk(stored.position, stored.end, compression, size_bytes, start_ns, end_ns, None, crc)


def decode_message_index(data: Buffer, start: int, end: int) -> tuple[int, Iterator[tuple[int, int]]]:
    """Return a channel's number, and (time, offset in the chunk) of each of its messages."""
    fields = _Fields(data, start, end, "message index")
    number = fields.unpack(U16)[0]
    entries = fields.part()
    if (entries.end - entries.position) % U64_PAIR.size:
        raise RecordingError("a record (message index) ends within an entry")
    return number, U64_PAIR.iter_unpack(data[entries.position : entries.end])


def decode_chunk_index(data: Buffer, start: int, end: int) -> ChunkIndex:
    """Return a chunk index."""
    fields = _Fields(data, start, end, "chunk index")
    start_ns, end_ns, position, length = fields.unpack(CHUNK_LOCATION)
    indexes = fields.numbers()
    indexes_bytes = fields.unpack(U64)[0]
    compression = fields.text()
    compressed_bytes, size_bytes = fields.unpack(U64_PAIR)
    return ChunkIndex(
        start_ns, end_ns, position, length, indexes, indexes_bytes, compression, compressed_bytes, size_bytes
    )


def decode_statistics(data: Buffer, start: int, end: int) -> Statistics:
    """Return the statistics."""
    fields = _Fields(data, start, end, "statistics")
    messages, schemas, channels, attachments, metadata, chunks, start_ns, end_ns = fields.unpack(STATISTICS)
    counts = fields.numbers()
    return Statistics(messages, schemas, channels, attachments, metadata, chunks, start_ns, end_ns, counts)


def decode_footer(data: Buffer, start: int, end: int) -> tuple[int, int, int]:
    """Return the positions of summary and summary offsets (0 if missing), and the summary's checksum."""
    summary, offsets, crc = _Fields(data, start, end, "footer").unpack(FOOTER)
    return summary, offsets, crc
