"""Writes ROS 1 bags, format 2.0: chunks of messages with their index, straight bytes.

A chunk goes to the file at once when it is full or flushed, so a killed process leaves whole chunks behind,
which every reader finds by walking over the file. Index and counts of the file are written when it is closed.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from rostether.errors import RecordingError
from rostether.recording.bag.records import (
    CHUNK_INFO_VERSION,
    INDEX_VERSION,
    MAGIC,
    OP_CHUNK,
    OP_CHUNK_INFO,
    OP_CONNECTION,
    OP_INDEX,
    OP_MESSAGE,
    U32,
    U32_PAIR,
    U64,
    bag_header,
    encode_fields,
    encode_record,
    encode_time,
)
from rostether.recording.compression import NONE, check_compression, compress
from rostether.recording.output_file import OutputFile
from rostether.recording.recorded import Connection

DEFAULT_CHUNK_BYTES = 768 * 1024
"""What rosbag writes: enough to compress well, little enough to read for one message."""

# Length of the header, then conn (13 bytes with its length), op (8) and time (17) but for its value.
_MESSAGE_HEAD = struct.Struct("<II5sII4sI5s")
_MESSAGE_HEADER_BYTES = 38


@dataclass(frozen=True, slots=True)
class _ChunkInfo:
    position: int
    start_ns: int
    end_ns: int
    counts: tuple[tuple[int, int], ...]


class BagWriter:
    """A bag being written; see `recording.recorded.RecordingWriter`."""

    def __init__(
        self, path: Path, *, compression: str = NONE, chunk_bytes: int = DEFAULT_CHUNK_BYTES
    ) -> None:
        check_compression(compression)
        self.path = path
        self.message_count = 0
        self._compression = compression
        self._limit_bytes = chunk_bytes
        self._numbers: dict[Connection, int] = {}
        self._heads: list[bytes] = []
        self._records: list[bytes] = []
        self._infos: list[_ChunkInfo] = []
        self._is_closed = False
        self._file = OutputFile(path)
        # Connections whose record stands in a chunk that is in the file.
        self._known: set[int] = set()
        self._parts: list[bytes] = []
        self._chunk_bytes = 0
        self._index: dict[int, array[int]] = {}
        self._start_ns: int | None = None
        self._end_ns = 0
        self._is_sorted = True
        try:
            self._file.append(MAGIC + bag_header(0, 0, 0))
        except RecordingError:
            self._is_closed = True
            self._file.close()
            raise

    @property
    def size_bytes(self) -> int:
        """The file's size and what waits to be written."""
        return self._file.position + self._chunk_bytes

    def add_connection(self, connection: Connection) -> int:
        """Return the connection's number; equal connections share one."""
        number = self._numbers.get(connection)
        if number is None:
            number = self._numbers[connection] = len(self._heads)
            self._heads.append(_message_head(number))
            # When a damaged bag is repaired, even names may not be UTF-8.
            fields = {_encoded(name): _encoded(value) for name, value in connection.fields().items()}
            header = encode_fields(fields)
            self._records.append(
                encode_record(OP_CONNECTION, {b"conn": U32.pack(number), b"topic": fields[b"topic"]}, header)
            )
        return number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Take messages that came at one time. Raises RecordingError when the disk takes no more."""
        if not payloads:
            return
        index = self._index.get(number)
        if index is None:
            index = self._index[number] = array("I")
            if number not in self._known:
                self._parts.append(self._records[number])
                self._chunk_bytes += len(self._records[number])
        stamp = encode_time(time_ns)
        head = self._heads[number] + stamp
        secs, nsecs = U32_PAIR.unpack(stamp)
        sizes = [len(each) for each in payloads]
        offset = self._chunk_bytes
        if sizes.count(sizes[0]) == len(sizes):
            # The usual case, a flood of one size: no step of Python for each message.
            head += U32.pack(sizes[0])
            step = len(head) + sizes[0]
            self._parts.append(head + head.join(payloads))
            self._chunk_bytes += step * len(sizes)
            entries = array("I", bytes(12 * len(sizes)))
            entries[0::3] = array("I", (secs,)) * len(sizes)
            entries[1::3] = array("I", (nsecs,)) * len(sizes)
            entries[2::3] = array("I", range(offset, self._chunk_bytes, step))
            index.extend(entries)
        else:
            for size, payload in zip(sizes, payloads, strict=True):
                index.extend((secs, nsecs, offset))
                self._parts.append(head + U32.pack(size) + payload)
                offset += len(head) + 4 + size
            self._chunk_bytes = offset
        self._is_sorted = self._is_sorted and time_ns >= self._end_ns
        self._start_ns = time_ns if self._start_ns is None else min(self._start_ns, time_ns)
        self._end_ns = max(self._end_ns, time_ns)
        self.message_count += len(payloads)
        if self._chunk_bytes >= self._limit_bytes:
            self.flush()

    def flush(self) -> None:
        """End the chunk and write it. Raises RecordingError; the file then ends with the chunk before."""
        if self._start_ns is None:
            return
        plain = b"".join(self._parts)
        stored = compress(self._compression, plain)
        position = self._file.position
        if not self._is_sorted:
            # Debian's rosbag seeks in the index by bisection.
            self._index = {number: _sorted(entries) for number, entries in self._index.items()}
        counts = tuple((number, len(entries) // 3) for number, entries in self._index.items())
        record = encode_record(
            OP_CHUNK,
            {b"compression": self._compression.encode(), b"size": U32.pack(len(plain))},
            stored,
        )
        indexes = [_index_record(number, entries) for number, entries in self._index.items()]
        info = _ChunkInfo(position, self._start_ns, self._end_ns, counts)
        known = self._known | self._index.keys()
        self._begin_chunk()
        try:
            self._file.append(b"".join((record, *indexes)))
        except RecordingError:
            self.message_count -= sum(count for _, count in counts)
            raise
        self._known = known
        self._infos.append(info)

    def close(self) -> None:
        """Write the index and close the file. Idempotent. Raises RecordingError; the chunks are kept."""
        if self._is_closed:
            return
        self._is_closed = True
        try:
            try:
                self.flush()
            finally:
                self._write_index()
        finally:
            self._file.close()

    def _begin_chunk(self) -> None:
        self._parts = []
        self._chunk_bytes = 0
        self._index = {}
        self._start_ns = None
        self._end_ns = 0
        self._is_sorted = True

    def _write_index(self) -> None:
        position = self._file.position
        known = sorted(self._known)
        infos = (
            encode_record(
                OP_CHUNK_INFO,
                {
                    b"ver": U32.pack(CHUNK_INFO_VERSION),
                    b"chunk_pos": U64.pack(info.position),
                    b"start_time": encode_time(info.start_ns),
                    b"end_time": encode_time(info.end_ns),
                    b"count": U32.pack(len(info.counts)),
                },
                b"".join(U32_PAIR.pack(*each) for each in info.counts),
            )
            # Debian's rosbag takes the start of the first chunk and the end of the last for those of the bag.
            for info in sorted(self._infos, key=lambda info: (info.start_ns, info.end_ns))
        )
        self._file.append(b"".join((*(self._records[number] for number in known), *infos)))
        self._file.replace(len(MAGIC), bag_header(position, len(known), len(self._infos)))


def _message_head(number: int) -> bytes:
    op = b"op=" + bytes((OP_MESSAGE,))
    return _MESSAGE_HEAD.pack(_MESSAGE_HEADER_BYTES, 9, b"conn=", number, 4, op, 13, b"time=")


def _index_record(number: int, entries: array[int]) -> bytes:
    if sys.byteorder == "big":
        entries.byteswap()
    return encode_record(
        OP_INDEX,
        {
            b"ver": U32.pack(INDEX_VERSION),
            b"conn": U32.pack(number),
            b"count": U32.pack(len(entries) // 3),
        },
        entries.tobytes(),
    )


def _sorted(entries: array[int]) -> array[int]:
    triples = sorted(zip(entries[0::3], entries[1::3], entries[2::3], strict=True))
    return array("I", chain.from_iterable(triples))


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")
