"""Checks the data section of an MCAP file: chunks, messages and their indexes, schemas, channels."""

from __future__ import annotations

import zlib
from array import array
from collections import Counter
from collections.abc import Iterator

from msgspec import Struct, field

from rostether.errors import RecordingError
from rostether.recording.compression import MAX_CHUNK_BYTES, Buffer, check_unpacked_size, unpack_chunk
from rostether.recording.mcap.content import McapContent
from rostether.recording.mcap.records import (
    KINDS,
    MESSAGE_HEAD,
    Chunk,
    Op,
    decode_channel,
    decode_chunk,
    decode_message_index,
    decode_schema,
    read_record,
)
from rostether.recording.time_order import TimeOrder

# A broken file can have one fault in each record; a longer report does not help.
MAX_FAULTS = 50


class FoundChunk(Struct):
    """A chunk in the data section, and the message indexes that follow it.

    `message_offsets` has (time, offset) of each message by channel, until the indexes are compared.
    `indexes` has the positions of the message indexes by channel.
    """

    chunk: Chunk
    position: int
    length: int
    message_offsets: dict[int, array[int]] = field(default_factory=dict)
    indexes: dict[int, int] = field(default_factory=dict)
    indexes_end: int = 0


class TooManyFaultsError(Exception):
    """Ends a check that has reported enough faults."""


class DataCheck:
    """Reads the data section, collects its errors in `faults`, and what the summary must match."""

    def __init__(self, data: Buffer) -> None:
        self.faults: list[str] = []
        self.defined = McapContent()
        self.counts: dict[int, int] = {}
        self.span_ns: tuple[int, int] | None = None
        self.order = TimeOrder()
        self.kinds: Counter[int] = Counter()
        self.chunks: dict[int, FoundChunk] = {}
        self._packed_bytes = 0
        self._data = data

    def report(self, fault: str) -> None:
        """Add an error. Raises TooManyFaultsError."""
        self.faults.append(fault)
        if len(self.faults) >= MAX_FAULTS:
            raise TooManyFaultsError

    def check_data(self, position: int) -> int:
        """Check up to the end of the data section; return the position after it. Raises RecordingError."""
        data = self._data
        last: FoundChunk | None = None
        while True:
            before = position
            op, start, position = read_record(data, position)
            if op != Op.MESSAGE_INDEX:
                self._check_indexed(last)
                last = None
            self.kinds[op] += 1
            if op == Op.DATA_END:
                crc = int.from_bytes(bytes(data[start:position]), "little")
                if crc and zlib.crc32(data[:before]) != crc:
                    self.report("the checksum (CRC) of its data is wrong")
                return position
            if op == Op.CHUNK:
                last = self._check_chunk(before, start, position)
            elif op == Op.MESSAGE_INDEX:
                self._check_message_index(last, before, start, position)
            elif op in (Op.SCHEMA, Op.CHANNEL):
                self._define(data, op, start, position)
            elif op == Op.MESSAGE:
                self._count(*_message(data, start, position))
            elif op == Op.ATTACHMENT:
                crc = int.from_bytes(bytes(data[max(position - 4, start) : position]), "little")
                if crc and zlib.crc32(data[start : position - 4]) != crc:
                    self.report(f"the checksum (CRC) of the attachment at byte {before} is wrong")
            elif op != Op.METADATA and op < 0x80:
                raise RecordingError(f"there is a record ({record_name(op)}) among the data at byte {before}")

    def _check_chunk(self, position: int, start: int, end: int) -> FoundChunk:
        data = self._data
        chunk = decode_chunk(data, start, end)
        found = self.chunks[position] = FoundChunk(chunk, position, end - position, indexes_end=end)
        where = f"the chunk at byte {position}"
        if chunk.compression:
            self._packed_bytes += min(chunk.size_bytes, MAX_CHUNK_BYTES)
            # The summary may omit chunks.
            check_unpacked_size(self._packed_bytes, len(data))
        try:
            plain = unpack_chunk(memoryview(data)[chunk.data_start : chunk.data_end], chunk)
        except RecordingError as error:
            self.report(f"{where}: {error}")
            return found
        if chunk.crc and zlib.crc32(plain) != chunk.crc:
            self.report(f"{where}: the checksum (CRC) of its records is wrong")
        first, last = 1 << 64, -1
        try:
            for op, record, begin, stop in _records(plain):
                if op in (Op.SCHEMA, Op.CHANNEL):
                    self._define(plain, op, begin, stop)
                elif op == Op.MESSAGE:
                    number, time_ns = _message(plain, begin, stop)
                    self._count(number, time_ns)
                    first, last = min(first, time_ns), max(last, time_ns)
                    found.message_offsets.setdefault(number, array("Q")).extend((time_ns, record))
                elif op < 0x80:
                    self.report(f"{where}: a record ({record_name(op)}) does not belong there")
        except RecordingError as error:
            self.report(f"{where}: {error}")
        if found.message_offsets and (first, last) != (chunk.start_ns, chunk.end_ns):
            stated = f"{chunk.start_ns} to {chunk.end_ns}"
            self.report(f"{where}: its times are {first} to {last} ns, not {stated} as stated")
        return found

    def _check_message_index(self, found: FoundChunk | None, position: int, start: int, end: int) -> None:
        number, entries = decode_message_index(self._data, start, end)
        if found is None:
            self.report(f"the message index at byte {position} does not follow a chunk")
            return
        found.indexes[number] = position
        found.indexes_end = end
        listed = array("Q", (value for entry in entries for value in entry))
        there = found.message_offsets.get(number, array("Q"))
        if listed != there and _pairs(listed) != _pairs(there):
            self.report(
                f"the message index at byte {position} does not list the messages of channel {number} "
                "in the chunk before it"
            )

    def _check_indexed(self, found: FoundChunk | None) -> None:
        if found is not None and found.indexes:
            for number in found.message_offsets.keys() - found.indexes.keys():
                self.report(f"the chunk at byte {found.position}: channel {number} has no message index")
        if found is not None:
            found.message_offsets.clear()

    def _define(self, data: Buffer, op: int, start: int, end: int) -> None:
        if op == Op.SCHEMA:
            schema = decode_schema(data, start, end)
            if not schema.number:
                self.report("a schema has the invalid number 0")
            if self.defined.schemas.get(schema.number, schema) != schema:
                self.report(f"schema {schema.number} has two different definitions")
        else:
            channel = decode_channel(data, start, end)
            if self.defined.channels.get(channel.number, channel) != channel:
                self.report(f"channel {channel.number} has two different definitions")
            if channel.schema and channel.schema not in self.defined.schemas:
                self.report(f"channel {channel.number} uses schema {channel.schema}, which is not defined")
        self.defined.define(op, data, start, end)

    def _count(self, number: int, time_ns: int) -> None:
        if number not in self.counts:
            self.counts[number] = 0
            if number not in self.defined.channels:
                self.report(f"a message belongs to channel {number}, which is not defined")
        self.counts[number] += 1
        self.order.add(time_ns)
        first_ns, last_ns = self.span_ns or (time_ns, time_ns)
        self.span_ns = (min(first_ns, time_ns), max(last_ns, time_ns))


def _records(plain: Buffer) -> Iterator[tuple[int, int, int, int]]:
    """Yield kind, position, and start and end of the content, of the records in a chunk."""
    position = 0
    while position < len(plain):
        op, start, end = read_record(plain, position)
        yield op, position, start, end
        position = end


def _message(data: Buffer, start: int, end: int) -> tuple[int, int]:
    if end - start < MESSAGE_HEAD.size:
        raise RecordingError("a message is shorter than its header")
    number, _, time_ns, _ = MESSAGE_HEAD.unpack_from(data, start)
    return number, time_ns


def _pairs(values: array[int]) -> list[tuple[int, int]]:
    return sorted(zip(values[0::2], values[1::2], strict=True))


def record_name(op: int) -> str:
    """Return the name of a kind of record."""
    return KINDS.get(op, f"of kind {op:#x}")
