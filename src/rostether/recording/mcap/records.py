"""The records of an MCAP file and their fields.

    file     magic  header  (schema | channel | chunk  message index...)...  data end  summary  footer  magic
    record   u8 kind | u64 length | content
    chunk    its records are a sequence of schemas, channels and messages, possibly compressed
    summary  schemas and channels again, statistics, chunk indexes, and the position of each group of these

All integers are little-endian; texts have a u32 length before them. The functions that decode a record raise
RecordingError if it is shorter than its content. Source: mcap.dev/spec
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from enum import IntEnum

import msgspec

from rostether.errors import RecordingError
from rostether.recording.compression import Buffer, StoredChunk

MAGIC = b"\x89MCAP0\r\n"


class Op(IntEnum):
    """The kinds of records."""

    HEADER = 0x01
    FOOTER = 0x02
    SCHEMA = 0x03
    CHANNEL = 0x04
    MESSAGE = 0x05
    CHUNK = 0x06
    MESSAGE_INDEX = 0x07
    CHUNK_INDEX = 0x08
    ATTACHMENT = 0x09
    ATTACHMENT_INDEX = 0x0A
    STATISTICS = 0x0B
    METADATA = 0x0C
    METADATA_INDEX = 0x0D
    SUMMARY_OFFSET = 0x0E
    DATA_END = 0x0F


KINDS = {op.value: op.name.lower().replace("_", " ") for op in Op}

RECORD_HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<HIQQ")
CHUNK_HEAD = struct.Struct("<QQQI")
FOOTER = struct.Struct("<QQI")
FOOTER_BYTES = RECORD_HEAD.size + FOOTER.size
STATISTICS = struct.Struct("<QHIIIIQQ")
SUMMARY_OFFSET = struct.Struct("<BQQ")
U64_PAIR = struct.Struct("<QQ")
CHANNEL_AND_NUMBER = struct.Struct("<HQ")
CHUNK_LOCATION = struct.Struct("<QQQQ")
U16_PAIR = struct.Struct("<HH")
U16 = struct.Struct("<H")
U32 = struct.Struct("<I")
U64 = struct.Struct("<Q")


class Schema(msgspec.Struct, frozen=True):
    """A type: its name, the encoding of its definition, and the definition."""

    number: int
    name: str
    encoding: str
    data: bytes


class Channel(msgspec.Struct, frozen=True):
    """A topic of a publisher; the number of its schema is 0 if it has none."""

    number: int
    schema: int
    topic: str
    encoding: str
    metadata: Mapping[str, str]


class Chunk(StoredChunk, frozen=True):
    """A chunk; `crc` is the checksum of its uncompressed records, 0 without one."""

    crc: int


class ChunkIndex(msgspec.Struct, frozen=True):
    """The position of a chunk, and the positions of its message indexes by channel number (`indexes`)."""

    start_ns: int
    end_ns: int
    position: int
    length: int
    indexes: Mapping[int, int]
    indexes_bytes: int
    compression: str
    compressed_bytes: int
    size_bytes: int


class Statistics(msgspec.Struct, frozen=True):
    """The statistics of a file; `counts` has the number of messages by channel number."""

    message_count: int
    schema_count: int
    channel_count: int
    attachment_count: int
    metadata_count: int
    chunk_count: int
    start_ns: int
    end_ns: int
    counts: Mapping[int, int]


def encode_record(op: int, content: bytes) -> bytes:
    """Return a complete record."""
    return RECORD_HEAD.pack(op, len(content)) + content


def encode_text(text: str | bytes) -> bytes:
    """Return a string with its length."""
    data = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
    return U32.pack(len(data)) + data


def encode_map(values: Mapping[str, str]) -> bytes:
    """Return a map of strings, with its length."""
    return encode_text(b"".join(encode_text(key) + encode_text(value) for key, value in values.items()))


def encode_numbers(values: Mapping[int, int]) -> bytes:
    """Return a map of numbers by channel, with its length."""
    return encode_text(b"".join(CHANNEL_AND_NUMBER.pack(*each) for each in values.items()))


def encode_statistics(statistics: Statistics) -> bytes:
    """Return the record of statistics."""
    *numbers, counts = msgspec.structs.astuple(statistics)
    return encode_record(Op.STATISTICS, STATISTICS.pack(*numbers) + encode_numbers(counts))


def encode_chunk_index(index: ChunkIndex) -> bytes:
    """Return the record of a chunk's index."""
    parts = (
        CHUNK_LOCATION.pack(index.start_ns, index.end_ns, index.position, index.length),
        encode_numbers(index.indexes),
        U64.pack(index.indexes_bytes),
        encode_text(index.compression),
        U64_PAIR.pack(index.compressed_bytes, index.size_bytes),
    )
    return encode_record(Op.CHUNK_INDEX, b"".join(parts))


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
