"""Finds the contents of a bag by its index, or, without an index, by reading the whole file.

A recorder that was killed leaves no index. Its last chunk may have no size, because some recorders (roscpp's)
write messages before the chunk is complete; these messages are found one by one.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from rostether.errors import RecordingError
from rostether.recording.bag.records import (
    BAG_HEADER_BYTES,
    MAGIC,
    OP_BAG,
    OP_CHUNK,
    OP_CHUNK_INFO,
    OP_CONNECTION,
    OP_INDEX,
    OP_MESSAGE,
    U32,
    U32_PAIR,
    Fields,
    decode_fields,
    op_of,
    read_record,
    time_field,
    u32_field,
    u64_field,
)
from rostether.recording.chunk_order import Entry
from rostether.recording.compression import MAX_CHUNK_BYTES, NONE, Buffer, check_unpacked_size, decompress
from rostether.recording.packed_chunks import StoredChunk
from rostether.recording.recorded import Connection

# Ten times the connections of a fleet in a day; a compressed chunk could define millions in a few bytes.
MAX_CONNECTIONS = 100_000

# The limit for all connection headers; each one has a message definition of a few KB.
MAX_CONNECTIONS_BYTES = 256 << 20


@dataclass(frozen=True, slots=True)
class BagChunk(StoredChunk):
    """A chunk of a bag, with the number of messages of each connection."""

    counts: Mapping[int, int]


@dataclass(slots=True)
class BagContent:
    """The content of a bag; `damage` is the reason for a search, `whole_bytes` the intact part's size."""

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[BagChunk] = field(default_factory=list)
    damage: str = ""
    whole_bytes: int = 0
    connections_bytes: int = 0

    def add_connection(self, fields: Fields, header: Buffer) -> None:
        """Handle a connection record. Raises RecordingError, also if there are too many."""
        self.connections_bytes += len(header)
        if len(self.connections) >= MAX_CONNECTIONS or self.connections_bytes > MAX_CONNECTIONS_BYTES:
            found = f"{len(self.connections)} connections with {self.connections_bytes} bytes of definitions"
            raise RecordingError(f"it has at least {found}, more than the limit")
        named = {
            name.decode("utf-8", "surrogateescape"): value.decode("utf-8", "surrogateescape")
            for name, value in decode_fields(header).items()
        }
        topic = fields.get(b"topic", b"").decode("utf-8", "surrogateescape")
        self.connections[u32_field(fields, b"conn")] = Connection.from_fields(topic, named)


def read_content(data: Buffer, damage: str = "") -> BagContent:
    """Return the content of a bag, by its index, or by a search if the index is missing or damaged.

    Raises RecordingError if the file is not a bag.
    """
    start = len(MAGIC)
    if bytes(data[:start]) != MAGIC:
        raise RecordingError("it is not a bag of format 2.0")
    try:
        fields, _, data_end = read_record(data, start)
        if op_of(fields) != OP_BAG:
            raise RecordingError("it does not start with a bag header")
        index_position = u64_field(fields, b"index_pos")
        chunk_count = u32_field(fields, b"chunk_count")
    except RecordingError as error:
        return search(data, start + BAG_HEADER_BYTES + 8, str(error))
    if damage:
        content = BagContent(damage=damage)
        with contextlib.suppress(RecordingError):
            # This includes the connections of broken chunks.
            content.connections = _by_index(data, index_position, chunk_count).connections
        return search(data, data_end, damage, content)
    if index_position == 0:
        return search(data, data_end, "it was not closed")
    try:
        return _by_index(data, index_position, chunk_count)
    except RecordingError as error:
        return search(data, data_end, f"its index is broken: {error}")


def _by_index(data: Buffer, position: int, chunk_count: int) -> BagContent:
    content = BagContent(whole_bytes=len(data))
    while position < len(data):
        fields, start, position = read_record(data, position)
        op = op_of(fields)
        if op == OP_CONNECTION:
            content.add_connection(fields, data[start:position])
        elif op == OP_CHUNK_INFO:
            content.chunks.append(_indexed_chunk(data, fields, data[start:position]))
    if len(content.chunks) != chunk_count:
        raise RecordingError(f"it lists {len(content.chunks)} of {chunk_count} chunks")
    packed = (chunk.size_bytes for chunk in content.chunks if chunk.compression != NONE)
    check_unpacked_size(sum(min(each, MAX_CHUNK_BYTES) for each in packed), len(data))
    unknown = {number for chunk in content.chunks for number in chunk.counts} - content.connections.keys()
    if unknown:
        raise RecordingError(f"its index has no record of connection {min(unknown)}")
    return content


def _indexed_chunk(data: Buffer, fields: Fields, counts: Buffer) -> BagChunk:
    if len(counts) % U32_PAIR.size or len(counts) > MAX_CONNECTIONS * U32_PAIR.size:
        raise RecordingError("the counts of a chunk are truncated")
    chunk_fields, start, end = read_record(data, u64_field(fields, b"chunk_pos"))
    if op_of(chunk_fields) != OP_CHUNK:
        raise RecordingError("there is no chunk at a listed position")
    by_number = dict(U32_PAIR.iter_unpack(counts))
    return BagChunk(
        data_start=start,
        data_end=end,
        compression=chunk_fields.get(b"compression", b"").decode(errors="replace"),
        size_bytes=u32_field(chunk_fields, b"size"),
        start_ns=time_field(fields, b"start_time"),
        end_ns=time_field(fields, b"end_time"),
        numbers=frozenset(by_number),
        counts=by_number,
    )


def search(data: Buffer, position: int, damage: str, content: BagContent | None = None) -> BagContent:
    """Read the chunks from a position up to the last complete one.

    Raises RecordingError if their unpacked size is implausible.
    """
    check_unpacked_size(_packed_bytes(data, position), len(data))
    content = content or BagContent(damage=damage)
    content.whole_bytes = position
    try:
        while position < len(data):
            fields, start, end = read_record(data, position)
            op = op_of(fields)
            if op == OP_CHUNK:
                size = u32_field(fields, b"size")
                compression = fields.get(b"compression", b"").decode(errors="replace")
                if start == end and compression == NONE:
                    end = _end_of_open_chunk(data, start)
                    size = end - start
                try:
                    _add_found(content, data, (start, end), compression, size)
                except RecordingError as error:  # the next one may be whole
                    content.damage = f"{damage}; {error}" if str(error) not in damage else damage
            elif op not in (OP_INDEX, OP_CONNECTION, OP_CHUNK_INFO):
                raise RecordingError(f"there is a record of an unknown kind ({op:#x}) at byte {position}")
            position = content.whole_bytes = end
    except RecordingError as error:
        content.damage = f"{content.damage}; {error}"
    return content


def _packed_bytes(data: Buffer, position: int) -> int:
    """Return the total unpacked size, from the headers of the chunks after a position."""
    total = 0
    with contextlib.suppress(RecordingError):
        while position < len(data):
            fields, _, position = read_record(data, position)
            if op_of(fields) == OP_CHUNK and fields.get(b"compression", b"") != NONE.encode():
                total += min(u32_field(fields, b"size"), MAX_CHUNK_BYTES)
    return total


def _end_of_open_chunk(data: Buffer, position: int) -> int:
    try:
        while position < len(data):
            fields, _, end = read_record(data, position)
            if op_of(fields) not in (OP_MESSAGE, OP_CONNECTION):
                break
            position = end
    except RecordingError:
        pass  # the file ends here
    return position


def _add_found(
    content: BagContent, data: Buffer, span: tuple[int, int], compression: str, size_bytes: int
) -> None:
    plain = decompress(compression, memoryview(data)[slice(*span)], size_bytes)
    counts: dict[int, int] = {}
    first_ns, last_ns = 1 << 64, -1
    for time_ns, _, _, number in messages_in(plain, content.add_connection):
        if number not in content.connections:
            raise RecordingError(f"a message belongs to connection {number}, which is not defined")
        counts[number] = counts.get(number, 0) + 1
        first_ns = min(first_ns, time_ns)
        last_ns = max(last_ns, time_ns)
    if counts:
        numbers = frozenset(counts)
        content.chunks.append(BagChunk(*span, compression, size_bytes, first_ns, last_ns, numbers, counts))


def messages_in(
    plain: Buffer, on_connection: Callable[[Fields, Buffer], None] | None = None
) -> Iterator[Entry]:
    """Yield time in ns, start and end of the payload, and the connection's number, of each message.

    Raises RecordingError if a record is truncated.
    """
    # The fast path: most writers order the header as conn, op, time.
    position = 0
    length = len(plain)
    pair = U32_PAIR.unpack_from
    one = U32.unpack_from
    while position < length:
        if (
            plain[position : position + 13] == b"\x26\x00\x00\x00\x09\x00\x00\x00conn="
            and plain[position + 17 : position + 34] == b"\x04\x00\x00\x00op=\x02\x0d\x00\x00\x00time="
            and position + 46 <= length
        ):
            secs, nsecs = pair(plain, position + 34)
            start = position + 46
            end = start + one(plain, position + 42)[0]
            if end > length:
                raise RecordingError("a chunk ends within a message")
            yield secs * 1_000_000_000 + nsecs, start, end, one(plain, position + 13)[0]
        else:
            fields, start, end = read_record(plain, position)
            op = op_of(fields)
            if op == OP_MESSAGE:
                yield time_field(fields, b"time"), start, end, u32_field(fields, b"conn")
            elif op == OP_CONNECTION and on_connection is not None:
                on_connection(fields, plain[start:end])
        position = end
