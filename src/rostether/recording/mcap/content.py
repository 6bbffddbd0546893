"""The content of an MCAP file, and the search for it if the file has no valid summary."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator

from msgspec import field
from msgspec.structs import replace

from rostether.errors import RecordingError
from rostether.recording.chunk_order import Entry
from rostether.recording.chunked_reader import ChunkedContent, tally
from rostether.recording.compression import (
    MAX_CHUNK_BYTES,
    Buffer,
    StoredChunk,
    check_unpacked_size,
    unpack_chunk,
)
from rostether.recording.mcap.records import (
    CHUNK_HEAD,
    MAGIC,
    MESSAGE_HEAD,
    RECORD_HEAD,
    U32,
    U64,
    Channel,
    Op,
    Schema,
    check_header,
    decode_channel,
    decode_chunk,
    decode_schema,
    read_record,
)

# The limit for all schemas and channels, a few KB each: a compressed chunk could define gigabytes of them.
MAX_DEFINITION_BYTES = 256 << 20

# The start of a chunk: its kind, its length below 1 TB, its times, size and checksum, and its compression.
_CHUNK_HEAD = re.compile(rb"\x06.{5}\0\0\0.{28}(?:\0\0\0\0|\x03\0\0\0lz4|\x04\0\0\0zstd)", re.DOTALL)

# Messages outside of chunks are read together up to this size.
MAX_LOOSE_BYTES = 4 << 20


class McapContent(ChunkedContent):
    """The content of an MCAP file."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[StoredChunk] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    span_ns: tuple[int, int] | None = None
    definition_bytes: int = 0

    def define(self, op: int, data: Buffer, start: int, end: int) -> None:
        """Add the schema or channel of a record; duplicates are allowed. Raises RecordingError."""
        self.definition_bytes += end - start
        if self.definition_bytes > MAX_DEFINITION_BYTES:
            raise RecordingError(f"it has more than {MAX_DEFINITION_BYTES} bytes of definitions")
        if op == Op.SCHEMA:
            schema = decode_schema(data, start, end)
            self.schemas[schema.number] = schema
        else:
            channel = decode_channel(data, start, end)
            self.channels[channel.number] = channel


def search(data: Buffer, damage: str) -> McapContent:
    """Read all complete records; after a broken record, continue at the next chunk.

    Raises RecordingError if the unpacked size of its chunks is implausible.
    """
    content = McapContent(damage=damage)
    check_unpacked_size(_define_channels(content, data), len(data))
    position = len(MAGIC)
    while position < len(data):
        before = position
        try:
            op, start, position = _known_record(data, before)
            if op == Op.MESSAGE:
                position = _end_of_messages(data, position, before + MAX_LOOSE_BYTES)
                _add_found(content, data, _plain_chunk(before, position))
            elif op == Op.CHUNK:
                _add_found(content, data, decode_chunk(data, start, position))
            elif op in (Op.SCHEMA, Op.CHANNEL):
                content.define(op, data, start, position)
            elif op == Op.HEADER:
                check_header(data, start, position)
            elif op == Op.DATA_END:
                break
        except RecordingError as error:
            content.note(str(error))
            end = position if position > before else len(data)
            position = min(end, _next_chunk(data, before + 1))
            with contextlib.suppress(RecordingError):
                _add_cut_chunk(content, data, before, position)
    content.chunks.sort(key=lambda chunk: chunk.start_ns)
    return content


def _known_record(data: Buffer, position: int) -> tuple[int, int, int]:
    op, start, end = read_record(data, position)
    if op == 0:
        raise RecordingError(f"there is no record at byte {position}")
    return op, start, end


def _next_chunk(data: Buffer, position: int) -> int:
    """Return the position of the next chunk, or the end of the file."""
    for found in _CHUNK_HEAD.finditer(data, position):
        with contextlib.suppress(RecordingError):
            _, start, end = read_record(data, found.start())
            if decode_chunk(data, start, end).data_end == end:
                return found.start()
    return len(data)


def _end_of_messages(data: Buffer, position: int, limit: int) -> int:
    """Return the end of the messages that follow each other from a position on, up to a limit."""
    with contextlib.suppress(RecordingError):
        while position < limit:
            op, _, end = read_record(data, position)
            if op != Op.MESSAGE:
                break
            position = end
    return position


def _plain_chunk(start: int, end: int) -> StoredChunk:
    return StoredChunk(start, end, "", end - start, 0, 0, None)


def _define_channels(content: McapContent, data: Buffer) -> int:
    """Add the schemas and channels outside of chunks, because a broken chunk may have defined them.

    Returns the total unpacked size of the chunks, from their headers.
    """
    total, position = 0, len(MAGIC)
    while position < len(data):
        before = position
        try:
            op, start, position = _known_record(data, before)
            if op in (Op.SCHEMA, Op.CHANNEL):
                content.define(op, data, start, position)
            elif op == Op.CHUNK and (chunk := decode_chunk(data, start, position)).compression:
                total += min(chunk.size_bytes, MAX_CHUNK_BYTES)
        except RecordingError:
            end = position if position > before else len(data)
            position = min(end, _next_chunk(data, before + 1))
    return total


def _add_cut_chunk(content: McapContent, data: Buffer, position: int, limit: int) -> None:
    """Read the complete messages of an uncompressed chunk that is broken, up to a position."""
    start = position + RECORD_HEAD.size + CHUNK_HEAD.size
    if data[position] != Op.CHUNK or bytes(data[start : start + U32.size]) != bytes(U32.size):
        return  # The length of the compression's name is 0 only in an uncompressed chunk.
    start += U32.size + U64.size
    before = end = start
    try:
        while end < limit:
            before, end = end, read_record(data, end, limit)[2]
    except RecordingError:
        # The damage may begin in the last record that can be read, unless the file ends here.
        end = end if limit == len(data) else before
    if end > start:
        _add_found(content, data, _plain_chunk(start, end))


def _add_found(content: McapContent, data: Buffer, chunk: StoredChunk) -> None:
    plain = unpack_chunk(memoryview(data)[chunk.data_start : chunk.data_end], chunk)
    found = messages_in(plain, content)
    counts, first_ns, last_ns = tally(found, content.channels, content.note, "channel")
    if not counts:
        return
    for number, count in counts.items():
        content.counts[number] = content.counts.get(number, 0) + count
    before = content.span_ns or (first_ns, last_ns)
    content.span_ns = (min(before[0], first_ns), max(before[1], last_ns))
    content.chunks.append(replace(chunk, start_ns=first_ns, end_ns=last_ns, numbers=frozenset(counts)))


def messages_in(plain: Buffer, defined: McapContent | None = None) -> Iterator[Entry]:
    """Yield time in ns, start and end of the payload, and the channel's number, of each message.

    Schemas and channels go to `defined`. Raises RecordingError if a record is truncated.
    """
    position = 0
    length = len(plain)
    head = MESSAGE_HEAD.unpack_from
    record = RECORD_HEAD.unpack_from
    record_bytes, head_bytes = RECORD_HEAD.size, MESSAGE_HEAD.size
    message, definitions = Op.MESSAGE, (Op.SCHEMA, Op.CHANNEL)
    while position < length:
        start = position + record_bytes
        if start > length:
            raise RecordingError("a chunk ends within a record")
        op, size = record(plain, position)
        position = start + size
        if position > length:
            raise RecordingError("a chunk ends within a record")
        if op == message:
            if size < head_bytes:
                raise RecordingError("a message is shorter than its header")
            number, _, time_ns, _ = head(plain, start)
            yield time_ns, start + head_bytes, position, number
        elif op in definitions and defined is not None:
            defined.define(op, plain, start, position)
