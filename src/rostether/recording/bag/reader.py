"""Reads ROS 1 bags, format 2.0, from any program: by their index, or by a search without a valid one."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from rostether.errors import RecordingError
from rostether.mechanisms.text import counted
from rostether.recording.bag.chunks import MAX_CONNECTIONS, BagChunk, BagContent, messages_in
from rostether.recording.bag.records import (
    BAG_HEADER_BYTES,
    MAGIC,
    MAGIC_START,
    U32_PAIR,
    Fields,
    Op,
    op_of,
    read_record,
    time_field,
    u32_field,
    u64_field,
)
from rostether.recording.bag.searching import search
from rostether.recording.chunked_reader import ChunkedReader
from rostether.recording.compression import MAX_CHUNK_BYTES, NONE, Buffer, check_unpacked_size
from rostether.recording.recorded import Connection


class BagReader(ChunkedReader[BagContent]):
    """A bag being read; see `recording.recorded.RecordingReader`.

    Raises RecordingError if the file is not a bag. `damage`, if given, is the reason not to use its index.
    """

    format_version = "2.0"
    unreadable: Mapping[str, str] = MappingProxyType({})

    def __init__(self, path: Path, *, damage: str = "") -> None:
        super().__init__(path, lambda view: read_content(view, damage), messages_in)
        self._connections = self._content.connections
        self._content.chunks.sort(key=lambda chunk: chunk.start_ns)

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        counts: Counter[Connection] = Counter(dict.fromkeys(self._connections.values(), 0))
        for chunk in self._content.chunks:
            for number, count in chunk.counts.items():
                counts[self._connections[number]] += count
        return counts

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message; None in an empty bag."""
        chunks = self._content.chunks
        return (chunks[0].start_ns, max(chunk.end_ns for chunk in chunks)) if chunks else None


def read_content(data: Buffer, damage: str = "") -> BagContent:
    """Return the content of a bag, by its index, or by a search if the index is missing or damaged.

    `damage`, if given, is the reason not to use the index. Raises RecordingError if the file is not a bag.
    """
    start = len(MAGIC)
    if (magic := bytes(data[:start])) != MAGIC:
        raise RecordingError(_other_format(magic))
    try:
        fields, _, data_end = read_record(data, start)
        if op_of(fields) != Op.BAG:
            raise RecordingError("it does not start with a bag header")
        index_position = u64_field(fields, b"index_pos")
        chunk_count = u32_field(fields, b"chunk_count")
    except RecordingError as error:
        # The header's two lengths have four bytes each.
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


def _other_format(start: bytes) -> str:
    if MAGIC.startswith(start):
        return f"it is truncated: it has only {counted(len(start), 'byte')}"
    if start.startswith(MAGIC_START):
        version = start[len(MAGIC_START) :].decode("latin-1").split("\n")[0]
        version = version.strip().encode("unicode_escape").decode()
        return f"it is a bag of format {version}; only 2.0 can be read"
    return "it is not a bag: bags start with '#ROSBAG V2.0'"


def _by_index(data: Buffer, position: int, chunk_count: int) -> BagContent:
    content = BagContent()
    while position < len(data):
        fields, start, position = read_record(data, position)
        op = op_of(fields)
        if op == Op.CONNECTION:
            content.add_connection(fields, data[start:position])
        elif op == Op.CHUNK_INFO:
            content.chunks.append(_indexed_chunk(data, fields, data[start:position]))
    if len(content.chunks) != chunk_count:
        raise RecordingError(f"it lists {len(content.chunks)} of {chunk_count} chunks")
    packed = (chunk.size_bytes for chunk in content.chunks if chunk.compression != NONE)
    check_unpacked_size(sum(min(each, MAX_CHUNK_BYTES) for each in packed), len(data))
    unknown = {number for chunk in content.chunks for number in chunk.counts} - content.connections.keys()
    if unknown:
        raise RecordingError(f"it has no record of connection {min(unknown)}")
    return content


def _indexed_chunk(data: Buffer, fields: Fields, counts: Buffer) -> BagChunk:
    if len(counts) % U32_PAIR.size or len(counts) > MAX_CONNECTIONS * U32_PAIR.size:
        raise RecordingError("the counts of a chunk are truncated")
    chunk_fields, start, end = read_record(data, u64_field(fields, b"chunk_pos"))
    if op_of(chunk_fields) != Op.CHUNK:
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
