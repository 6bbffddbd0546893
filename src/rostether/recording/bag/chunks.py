"""Finds the contents of a bag by its index, or, without an index, by reading the whole file.

A recorder that was killed leaves no index. Its last chunk may have no size, because some recorders (roscpp's)
write messages before the chunk is complete; these messages are found one by one.
"""

from __future__ import annotations

import contextlib
import re
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


# The limit of reported reasons: every chunk may be damaged in another way.
MAX_DAMAGE_CHARS = 500

# A chunk's header has the fields op, compression and size in any order: the field op, and the numbers of
# bytes that can come before it (the header's length, and 13 bytes of size, 19 or 20 of compression, or both).
_CHUNK_KIND = re.compile(rb"\x04\x00\x00\x00op=\x05")
_BEFORE_KIND = (4, 17, 23, 24, 36, 37)
_MAX_CHUNK_HEADER_BYTES = 41


@dataclass(frozen=True, slots=True)
class BagChunk(StoredChunk):
    """A chunk of a bag, with the number of messages of each connection."""

    counts: Mapping[int, int]


@dataclass(slots=True)
class BagContent:
    """The content of a bag; `damage` is the reason for a search."""

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[BagChunk] = field(default_factory=list)
    damage: str = ""
    connections_bytes: int = 0

    def note(self, damage: str) -> None:
        """Add a reason why the file is damaged; only the first reasons are kept."""
        if damage not in self.damage and len(self.damage) < MAX_DAMAGE_CHARS:
            self.damage = f"{self.damage}; {damage}"

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
    content = BagContent()
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
    """Read all complete chunks from a position, and the beginning of broken ones that are not compressed.

    Raises RecordingError if their unpacked size is implausible.
    """
    content = content or BagContent(damage=damage)
    check_unpacked_size(_define_connections(content, data, position), len(data))
    for op, fields, start, end in _records(data, position, content.note):
        if op != OP_CHUNK:
            continue
        compression = _compression_of(fields)
        try:
            # The size of an open chunk is not written yet.
            size = u32_field(fields, b"size") or end - start
            _add_found(content, data, (start, end), compression, size)
        except RecordingError as error:
            content.note(str(error))
            if compression == NONE:
                # The damage may begin in the last message that can be read.
                end = min(end, _end_of_messages(data, start, leaves_last=True))
                with contextlib.suppress(RecordingError):
                    _add_found(content, data, (start, end), compression, end - start)
    return content


def _records(
    data: Buffer, position: int, note: Callable[[str], None]
) -> Iterator[tuple[int, Fields, int, int]]:
    """Yield kind, fields, and start and end of the data, of each record; go on at a chunk after damage."""
    while position < len(data):
        try:
            op, fields, start, end = _known_record(data, position)
        except RecordingError as error:
            note(str(error))
            position = _next_chunk(data, position + 1)
            continue
        if op == OP_CHUNK:
            if start == end and _compression_of(fields) == NONE:
                end = _end_of_messages(data, start)
            try:
                if end < len(data):
                    _known_record(data, end)
            except RecordingError:
                # The length of this chunk may be the damage.
                end = min(end, _next_chunk(data, start))
        yield op, fields, start, end
        position = end


def _known_record(data: Buffer, position: int) -> tuple[int, Fields, int, int]:
    fields, start, end = read_record(data, position)
    op = op_of(fields)
    if op not in (OP_CHUNK, OP_INDEX, OP_CONNECTION, OP_CHUNK_INFO):
        raise RecordingError(f"there is a record of an unknown kind ({op:#x}) at byte {position}")
    return op, fields, start, end


def _next_chunk(data: Buffer, position: int) -> int:
    """Return the position of the next chunk, or the end of the file."""
    for found in _CHUNK_KIND.finditer(data, position):
        for before in _BEFORE_KIND:
            start = found.start() - before
            if start >= position and U32.unpack_from(data, start)[0] <= _MAX_CHUNK_HEADER_BYTES:
                with contextlib.suppress(RecordingError):
                    fields, _, _ = read_record(data, start)
                    if fields.keys() == {b"op", b"compression", b"size"}:
                        return start
    return len(data)


def _compression_of(fields: Fields) -> str:
    return fields.get(b"compression", b"").decode(errors="replace")


def _define_connections(content: BagContent, data: Buffer, position: int) -> int:
    """Add the connections defined outside of chunks, because a broken chunk may have defined them.

    Returns the total unpacked size of the chunks, from their headers.
    """
    total = 0
    for op, fields, start, end in _records(data, position, lambda _: None):
        with contextlib.suppress(RecordingError):
            if op == OP_CONNECTION:
                content.add_connection(fields, data[start:end])
            elif op == OP_CHUNK and _compression_of(fields) != NONE:
                total += min(u32_field(fields, b"size"), MAX_CHUNK_BYTES)
    return total


def _end_of_messages(data: Buffer, position: int, *, leaves_last: bool = False) -> int:
    """Return the end of the records in a chunk, or of those before its last one."""
    before = position
    try:
        while position < len(data):
            fields, _, end = read_record(data, position)
            if op_of(fields) not in (OP_MESSAGE, OP_CONNECTION):
                break
            before, position = position, end
    except RecordingError:
        pass  # the file or its intact part ends here
    return before if leaves_last else position


def _add_found(
    content: BagContent, data: Buffer, span: tuple[int, int], compression: str, size_bytes: int
) -> None:
    plain = decompress(compression, memoryview(data)[slice(*span)], size_bytes)
    counts: dict[int, int] = {}
    first_ns, last_ns = 1 << 64, -1
    for time_ns, _, _, number in messages_in(plain, content.add_connection):
        if number not in content.connections:
            content.note(f"messages belong to connection {number}, which is not defined")
            continue
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
