"""Writes ROS 1 bags, format 2.0: chunks of messages with their index.

The file's index and counts are written when it is closed. If the process is killed before, readers find the
chunks by a search.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path

import msgspec

from rostether.recording.bag.records import (
    CHUNK_INFO_VERSION,
    INDEX_VERSION,
    MAGIC,
    U32,
    U32_PAIR,
    U64,
    Op,
    bag_header,
    encode_fields,
    encode_record,
    encode_time,
)
from rostether.recording.chunked_writer import DEFAULT_CHUNK_BYTES, ChunkedWriter
from rostether.recording.compression import NONE
from rostether.recording.recorded import Connection

# The beginning of a message record: the length of its header, and the fields conn, op and time. With their
# lengths, they have 13, 8 and 17 bytes; the value of time (8 bytes) is added later.
_MESSAGE_HEAD = struct.Struct("<II5sII4sI5s")
_MESSAGE_HEADER_BYTES = 38


class _ChunkInfo(msgspec.Struct, frozen=True):
    position: int
    start_ns: int
    end_ns: int
    counts: tuple[tuple[int, int], ...]


class BagWriter(ChunkedWriter):
    """A bag being written; see `recording.recorded.RecordingWriter`."""

    _index_code = "I"

    def __init__(
        self, path: Path, *, compression: str = NONE, chunk_bytes: int = DEFAULT_CHUNK_BYTES
    ) -> None:
        self._numbers: dict[Connection, int] = {}
        self._heads: list[bytes] = []
        self._records: list[bytes] = []
        self._infos: list[_ChunkInfo] = []
        # Connections whose record is in a written chunk.
        self._known: set[int] = set()
        super().__init__(path, compression, chunk_bytes, MAGIC + bag_header(0, 0, 0))

    def add_connection(self, connection: Connection) -> int:
        """Add a connection if it is new; return its number. Equal connections share one."""
        number = self._numbers.get(connection)
        if number is None:
            number = self._numbers[connection] = len(self._heads)
            self._heads.append(_message_head(number))
            # In a damaged bag, even names may not be UTF-8.
            fields = {_encoded(name): _encoded(value) for name, value in connection.fields().items()}
            header = encode_fields(fields)
            self._records.append(
                encode_record(Op.CONNECTION, {b"conn": U32.pack(number), b"topic": fields[b"topic"]}, header)
            )
        return number

    def _write_chunk(self, plain: bytes, stored: bytes, start_ns: int) -> None:
        position = self._file.position
        if not self._is_sorted:
            # Debian's rosbag searches the index by bisection.
            self._index = {number: _sorted(entries) for number, entries in self._index.items()}
        counts = tuple((number, len(entries) // 3) for number, entries in self._index.items())
        record = encode_record(
            Op.CHUNK, {b"compression": self._compression.encode(), b"size": U32.pack(len(plain))}, stored
        )
        indexes = [_index_record(number, entries) for number, entries in self._index.items()]
        info = _ChunkInfo(position, start_ns, self._end_ns, counts)
        known = self._known | self._index.keys()
        self._append_chunk(b"".join((record, *indexes)), sum(count for _, count in counts))
        self._known = known
        self._infos.append(info)

    def _pop_unwritten(self, number: int) -> Iterable[bytes]:
        return () if number in self._known else (self._records[number],)

    def _message_form(self, number: int, time_ns: int) -> tuple[tuple[int, ...], Callable[[int], bytes]]:
        stamp = encode_time(time_ns)
        head = self._heads[number] + stamp
        return U32_PAIR.unpack(stamp), lambda size: head + U32.pack(size)

    def _write_end(self) -> None:
        position = self._file.position
        known = sorted(self._known)
        infos = (
            encode_record(
                Op.CHUNK_INFO,
                {
                    b"ver": U32.pack(CHUNK_INFO_VERSION),
                    b"chunk_pos": U64.pack(info.position),
                    b"start_time": encode_time(info.start_ns),
                    b"end_time": encode_time(info.end_ns),
                    b"count": U32.pack(len(info.counts)),
                },
                b"".join(U32_PAIR.pack(*each) for each in info.counts),
            )
            # Debian's rosbag uses the start of the first chunk and the end of the last chunk as those of the
            # bag.
            for info in sorted(self._infos, key=lambda info: (info.start_ns, info.end_ns))
        )
        self._file.append(b"".join((*(self._records[number] for number in known), *infos)))
        self._file.replace(len(MAGIC), bag_header(position, len(known), len(self._infos)))


def _message_head(number: int) -> bytes:
    op = b"op=" + bytes((Op.MESSAGE,))
    return _MESSAGE_HEAD.pack(_MESSAGE_HEADER_BYTES, 9, b"conn=", number, 4, op, 13, b"time=")


def _index_record(number: int, entries: array[int]) -> bytes:
    if sys.byteorder == "big":
        entries.byteswap()
    return encode_record(
        Op.INDEX,
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
