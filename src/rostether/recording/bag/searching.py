"""Finds the contents of a bag without its index, by reading the whole file.

A recorder that was killed leaves no index. Its last chunk may have no size, because some recorders (roscpp's)
write messages before the chunk is complete; these messages are found one by one. After damage, the search
continues at the next chunk.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator

from rostether.errors import RecordingError
from rostether.recording.bag.chunks import BagChunk, BagContent, messages_in
from rostether.recording.bag.records import U32, Fields, Op, op_of, read_record, u32_field
from rostether.recording.chunked_reader import tally
from rostether.recording.compression import MAX_CHUNK_BYTES, NONE, Buffer, check_unpacked_size, decompress

# The field op in the header of a chunk, whose fields op, compression and size may have any order.
_CHUNK_KIND = re.compile(rb"\x04\x00\x00\x00op=\x05")
# The possible numbers of bytes before it: 4 of the header's length, and 13 of size, 19 or 20 of compression,
# or both.
_BEFORE_KIND = (4, 17, 23, 24, 36, 37)
# The three fields have 8, 13, and at most 20 bytes.
_MAX_CHUNK_HEADER_BYTES = 41


def search(data: Buffer, position: int, damage: str, content: BagContent | None = None) -> BagContent:
    """Read all complete chunks from a position, and the beginning of broken ones that are not compressed.

    `content`, if given, is extended. Raises RecordingError if the unpacked size of the chunks is implausible.
    """
    content = content or BagContent(damage=damage)
    check_unpacked_size(_define_connections(content, data, position), len(data))
    for op, fields, start, end in _records(data, position, content.note):
        if op != Op.CHUNK:
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
    """Yield kind, fields, and start and end of the data, of each record; continue at a chunk after damage."""
    while position < len(data):
        try:
            op, fields, start, end = _known_record(data, position)
        except RecordingError as error:
            note(str(error))
            position = _next_chunk(data, position + 1)
            continue
        if op == Op.CHUNK:
            if start == end and _compression_of(fields) == NONE:
                end = _end_of_messages(data, start)
            try:
                if end < len(data):
                    _known_record(data, end)
            except RecordingError:
                # The length of this chunk may be damaged.
                end = min(end, _next_chunk(data, start))
        yield op, fields, start, end
        position = end


def _known_record(data: Buffer, position: int) -> tuple[int, Fields, int, int]:
    fields, start, end = read_record(data, position)
    op = op_of(fields)
    if op not in (Op.CHUNK, Op.INDEX, Op.CONNECTION, Op.CHUNK_INFO):
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
            if op == Op.CONNECTION:
                content.add_connection(fields, data[start:end])
            elif op == Op.CHUNK and _compression_of(fields) != NONE:
                total += min(u32_field(fields, b"size"), MAX_CHUNK_BYTES)
    return total


def _end_of_messages(data: Buffer, position: int, *, leaves_last: bool = False) -> int:
    """Return the end of the records in a chunk, or of those before its last one."""
    before = position
    try:
        while position < len(data):
            fields, _, end = read_record(data, position)
            if op_of(fields) not in (Op.MESSAGE, Op.CONNECTION):
                break
            before, position = position, end
    except RecordingError:
        pass  # The file or its intact part ends here.
    return before if leaves_last else position


def _add_found(
    content: BagContent, data: Buffer, span: tuple[int, int], compression: str, size_bytes: int
) -> None:
    plain = decompress(compression, memoryview(data)[slice(*span)], size_bytes)
    found = messages_in(plain, content.add_connection)
    counts, first_ns, last_ns = tally(found, content.connections, content.note, "connection")
    if counts:
        numbers = frozenset(counts)
        content.chunks.append(BagChunk(*span, compression, size_bytes, first_ns, last_ns, numbers, counts))
