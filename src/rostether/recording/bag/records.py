"""The records of a ROS 1 bag, format 2.0, and their header fields.

    file     "#ROSBAG V2.0\\n"  bag header (4104 bytes)  (chunk  index...)...  connection...  chunk info...
    record   u32 header length | header | u32 data length | data
    header   (u32 field length | name "=" value)...
    chunk    its data is a sequence of connection and message records, possibly compressed

The index of a chunk lists (time, offset in the chunk) for each connection. All integers are little-endian.
Source: wiki.ros.org/Bags/Format/2.0
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import TypeAlias

from rostether.errors import RecordingError
from rostether.recording.compression import Buffer
from rostether.rostime import NS_PER_S

MAGIC = b"#ROSBAG V2.0\n"
MAGIC_START = b"#ROSBAG V"


class Op(IntEnum):
    """The kinds of records."""

    MESSAGE = 0x02
    BAG = 0x03
    INDEX = 0x04
    CHUNK = 0x05
    CHUNK_INFO = 0x06
    CONNECTION = 0x07


# The bag header and its padding, without the length fields: rosbag overwrites exactly this many bytes.
BAG_HEADER_BYTES = 4096

INDEX_VERSION = 1
CHUNK_INFO_VERSION = 1

U32 = struct.Struct("<I")
U32_PAIR = struct.Struct("<II")
U64 = struct.Struct("<Q")

Fields: TypeAlias = dict[bytes, bytes]


def encode_fields(fields: Mapping[bytes, bytes]) -> bytes:
    """Return a header of fields, without its length."""
    return b"".join(
        U32.pack(len(name) + 1 + len(value)) + name + b"=" + value for name, value in fields.items()
    )


def encode_record(op: int, fields: Mapping[bytes, bytes], data: bytes) -> bytes:
    """Return a complete record."""
    header = encode_fields({**fields, b"op": bytes((op,))})
    return b"".join((U32.pack(len(header)), header, U32.pack(len(data)), data))


def decode_fields(header: Buffer) -> Fields:
    """Return the fields of a header. Raises RecordingError if they do not fit."""
    data = bytes(header)
    fields: Fields = {}
    position = 0
    while position < len(data):
        start = position + 4
        if start > len(data):
            raise RecordingError("a record's header ends within a field")
        position = start + U32.unpack_from(data, start - 4)[0]
        name, equals, value = data[start:position].partition(b"=")
        if position > len(data) or not equals:
            raise RecordingError("a record's header contains an invalid field")
        fields[name] = value
    return fields


def read_record(data: Buffer, position: int) -> tuple[Fields, int, int]:
    """Return a record's fields, and start and end of its data. Raises RecordingError if it is damaged."""
    start = position + 4
    if start > len(data):
        raise RecordingError("the file ends within a record")
    end = start + U32.unpack_from(data, position)[0]
    if end + 4 > len(data):
        raise RecordingError("the file ends within a record's header")
    data_start = end + 4
    data_end = data_start + U32.unpack_from(data, end)[0]
    if data_end > len(data):
        raise RecordingError("the file ends within a record's data")
    return decode_fields(data[start:end]), data_start, data_end


def op_of(fields: Fields) -> int:
    """Return a record's kind. Raises RecordingError if it has none."""
    op = fields.get(b"op", b"")
    if len(op) != 1:
        raise RecordingError("a record has no kind")
    return op[0]


def u32_field(fields: Fields, name: bytes) -> int:
    """Return a uint32 field. Raises RecordingError if it is missing."""
    return _unpacked(fields, name, U32, "number")[0]


def u64_field(fields: Fields, name: bytes) -> int:
    """Return a uint64 field. Raises RecordingError if it is missing."""
    return _unpacked(fields, name, U64, "number")[0]


def time_field(fields: Fields, name: bytes) -> int:
    """Return a time field in nanoseconds. Raises RecordingError if it is missing."""
    secs, nsecs = _unpacked(fields, name, U32_PAIR, "time")
    return secs * NS_PER_S + nsecs


def _unpacked(fields: Fields, name: bytes, form: struct.Struct, noun: str) -> tuple[int, ...]:
    value = fields.get(name, b"")
    if len(value) != form.size:
        raise RecordingError(f"a record's header has no {noun} in the field {name.decode()}")
    return form.unpack(value)


def encode_time(time_ns: int) -> bytes:
    """Return a time in the format of headers; times out of range are clamped."""
    secs, nsecs = divmod(max(time_ns, 0), NS_PER_S)
    return U32_PAIR.pack(min(secs, 0xFFFFFFFF), nsecs)


def bag_header(index_position: int, connection_count: int, chunk_count: int) -> bytes:
    """Return the first record of a file, padded; an index position of 0 means that there is no index yet."""
    header = encode_fields(
        {
            b"op": bytes((Op.BAG,)),
            b"index_pos": U64.pack(index_position),
            b"conn_count": U32.pack(connection_count),
            b"chunk_count": U32.pack(chunk_count),
        }
    )
    padding = BAG_HEADER_BYTES - len(header)
    return U32.pack(len(header)) + header + U32.pack(padding) + b" " * padding
