"""Checks the structure of an MCAP file, record by record: checksums, positions, counts and references.

The order of the checks is that of the file: data section, summary, summary offsets, footer.
"""

from __future__ import annotations

from collections.abc import Mapping

from rostether.errors import RecordingError
from rostether.recording.compression import Buffer
from rostether.recording.mcap.content import McapContent
from rostether.recording.mcap.data_check import MAX_FAULTS, DataCheck, TooManyFaultsError, record_name
from rostether.recording.mcap.reader import footer_of, has_damaged_summary
from rostether.recording.mcap.records import (
    FOOTER_BYTES,
    MAGIC,
    SUMMARY_OFFSET,
    ChunkIndex,
    Op,
    Statistics,
    check_header,
    decode_chunk_index,
    decode_statistics,
    read_record,
)


def faults_of(data: Buffer) -> list[str]:
    """Return the errors, one line each, in the order of the file."""
    check = _Check(data)
    try:
        try:
            check.run()
        except RecordingError as error:
            check.report(str(error))
    except TooManyFaultsError:
        check.faults.append(f"more errors follow; only the first {MAX_FAULTS} are listed")
    return check.faults


class _Check(DataCheck):
    def run(self) -> None:
        data = self._data
        if bytes(data[: len(MAGIC)]) != MAGIC:
            raise RecordingError("it does not start with MCAP's magic bytes")
        op, start, position = read_record(data, len(MAGIC))
        if op != Op.HEADER:
            raise RecordingError(f"there is a record ({record_name(op)}) instead of the header")
        check_header(data, start, position)
        position = self.check_data(position)
        if self.order.fault:
            self.report(self.order.fault)
        summary, offsets, crc = footer_of(data)
        footer = len(data) - len(MAGIC) - FOOTER_BYTES
        if not summary:
            self.report("it has no summary")
            return
        if summary != position or not summary <= (offsets or footer) <= footer:
            raise RecordingError(f"its footer states that the summary starts at {summary}, not at {position}")
        if has_damaged_summary(data, summary, crc):
            self.report("the checksum (CRC) of its summary is wrong")
        groups = self._check_summary(summary, offsets or footer)
        if offsets:
            self._check_offsets(offsets, footer, groups)

    def _check_summary(self, position: int, end: int) -> dict[int, tuple[int, int]]:
        """Check the records of the summary; return start and end of each group of records."""
        data = self._data
        groups: dict[int, tuple[int, int]] = {}
        repeated = McapContent()
        statistics: Statistics | None = None
        last_op = -1
        while position < end:
            before = position
            op, start, position = read_record(data, position, end)
            if op != last_op and op in groups:
                self.report(f"records of its summary ({record_name(op)}) are not grouped together")
            last_op = op
            groups[op] = (groups[op][0] if op in groups else before, position)
            if op in (Op.SCHEMA, Op.CHANNEL):
                repeated.define(op, data, start, position)
            elif op == Op.STATISTICS:
                if statistics is not None:
                    self.report("it has two statistics records")
                statistics = decode_statistics(data, start, position)
            elif op == Op.CHUNK_INDEX:
                self._check_chunk_index(decode_chunk_index(data, start, position))
        for found in self.chunks.values():
            self.report(f"its summary does not list the chunk at byte {found.position}")
        self._check_repeated("schema", repeated.schemas, self.defined.schemas)
        self._check_repeated("channel", repeated.channels, self.defined.channels)
        if statistics is None:
            self.report("it has no statistics")
        else:
            self._check_statistics(statistics)
        return groups

    def _check_repeated(self, kind: str, summary: Mapping[int, object], data: Mapping[int, object]) -> None:
        for number, value in summary.items():
            if number not in data:
                self.report(f"its summary lists {kind} {number}, which is not in its data")
            elif data[number] != value:
                self.report(f"its summary and its data differ in {kind} {number}")
        if summary:
            for number in data.keys() - summary.keys():
                self.report(f"its summary does not list {kind} {number}")

    def _check_chunk_index(self, index: ChunkIndex) -> None:
        found = self.chunks.pop(index.position, None)
        if found is None:
            self.report(
                f"its summary lists a chunk at byte {index.position} that does not exist, or lists it twice"
            )
            return
        chunk = found.chunk
        expected = ChunkIndex(
            start_ns=chunk.start_ns,
            end_ns=chunk.end_ns,
            position=found.position,
            length=found.length,
            # The positions of message indexes are optional.
            indexes=found.indexes if index.indexes else {},
            indexes_bytes=found.indexes_end - found.position - found.length,
            compression=chunk.compression,
            compressed_bytes=chunk.data_end - chunk.data_start,
            size_bytes=chunk.size_bytes,
        )
        if index != expected:
            self.report(f"its summary describes the chunk at byte {index.position} wrongly")

    def _check_statistics(self, statistics: Statistics) -> None:
        first, last = self.span_ns or (0, 0)
        rows = (
            ("messages", statistics.message_count, sum(self.counts.values())),
            ("schemas", statistics.schema_count, len(self.defined.schemas)),
            ("channels", statistics.channel_count, len(self.defined.channels)),
            ("attachments", statistics.attachment_count, self.kinds[Op.ATTACHMENT]),
            ("records of metadata", statistics.metadata_count, self.kinds[Op.METADATA]),
            ("chunks", statistics.chunk_count, self.kinds[Op.CHUNK]),
            ("ns at the first message", statistics.start_ns, first),
            ("ns at the last message", statistics.end_ns, last),
        )
        for noun, stated, there in rows:
            if stated != there:
                self.report(f"its statistics state {stated} {noun}, not {there}")
        counts = {number: count for number, count in statistics.counts.items() if count}
        if counts and counts != self.counts:
            self.report("its statistics have wrong message counts for channels")

    def _check_offsets(self, position: int, end: int, groups: dict[int, tuple[int, int]]) -> None:
        data = self._data
        while position < end:
            op, start, position = read_record(data, position, end)
            if op != Op.SUMMARY_OFFSET or position - start < SUMMARY_OFFSET.size:
                self.report(f"there is a record ({record_name(op)}) among its summary offsets")
                continue
            kind, begin, length = SUMMARY_OFFSET.unpack_from(data, start)
            if length and groups.get(kind) != (begin, begin + length):
                self.report(f"its summary offset of {record_name(kind)} is wrong")
