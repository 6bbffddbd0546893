"""The records of an MCAP file and their fields.

    file     magic  header  (schema | channel | chunk  message index...)...  data end  summary  footer  magic
    record   u8 kind | u64 length | content
    chunk    its records are a sequence of schemas, channels and messages, possibly compressed
    summary  schemas and channels again, statistics, chunk indexes, and the position of each group of these

All integers are little-endian; texts have a u32 length before them. Source: mcap.dev/spec
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from enum import IntEnum

import msgspec

from rostether.recording.compression import StoredChunk

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
