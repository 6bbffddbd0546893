"""Checks the structure of a ROS 1 bag: compares its chunks with its indexes."""

from __future__ import annotations

import struct

from rostether.errors import RecordingError
from rostether.mechanisms.text import counted
from rostether.recording.bag.chunks import BagChunk, messages_in
from rostether.recording.bag.reader import read_content
from rostether.recording.bag.records import Op, op_of, read_record, time_field, u32_field
from rostether.recording.compression import Buffer, unpack_chunk
from rostether.recording.time_order import TimeOrder
from rostether.rostime import NS_PER_S

# A broken bag can have one fault in each chunk; a longer report does not help.
MAX_FAULTS = 50

# The entry of a message in a chunk's index: time (secs and nsecs), and offset in the chunk.
_ENTRY = struct.Struct("<III")


def faults_of(data: Buffer) -> list[str]:
    """Return the errors, one line each. Raises RecordingError if the file is not a bag."""
    content = read_content(data)
    faults: list[str] = []
    if content.damage:
        return faults  # There is no index to compare with.
    order = TimeOrder()
    for chunk in sorted(content.chunks, key=lambda each: each.data_start):
        found = _chunk_faults(data, chunk, order)
        faults += (f"the chunk at byte {chunk.data_start}: {each}" for each in found)
        if len(faults) > MAX_FAULTS:
            return [*faults[:MAX_FAULTS], f"more errors follow; only the first {MAX_FAULTS} are listed"]
    if order.fault:
        faults.append(order.fault)
    return faults


def _chunk_faults(data: Buffer, chunk: BagChunk, order: TimeOrder) -> list[str]:
    faults: list[str] = []
    counts: dict[int, int] = {}
    first, last = 1 << 64, -1
    try:
        plain = unpack_chunk(memoryview(data)[chunk.data_start : chunk.data_end], chunk)
        for time_ns, _, _, number in messages_in(plain):
            counts[number] = counts.get(number, 0) + 1
            first, last = min(first, time_ns), max(last, time_ns)
            order.add(time_ns)
    except RecordingError as error:
        return [str(error)]
    if counts != {number: count for number, count in chunk.counts.items() if count}:
        faults.append("the bag's index has a wrong number of messages")
    if counts and (first, last) != (chunk.start_ns, chunk.end_ns):
        stated = f"{chunk.start_ns} to {chunk.end_ns}"
        faults.append(f"its times are {first} to {last} ns, not {stated} as in the bag's index")
    try:
        _check_indexes(data, chunk.data_end, plain, counts)
    except RecordingError as error:
        faults.append(f"the index after it is wrong: {error}")
    return faults


def _check_indexes(data: Buffer, position: int, plain: Buffer, counts: dict[int, int]) -> None:
    """Raise RecordingError unless the indexes after a chunk list all of its messages."""
    indexed = dict.fromkeys(counts, 0)
    while position < len(data):
        fields, start, end = read_record(data, position)
        if op_of(fields) != Op.INDEX:
            break
        number = u32_field(fields, b"conn")
        if (end - start) % _ENTRY.size:
            raise RecordingError("it ends within an entry")
        offsets = set()
        for secs, nsecs, offset in _ENTRY.iter_unpack(data[start:end]):
            there, _, _ = read_record(plain, offset)
            if (
                op_of(there) != Op.MESSAGE
                or u32_field(there, b"conn") != number
                or time_field(there, b"time") != secs * NS_PER_S + nsecs
            ):
                raise RecordingError(
                    f"byte {offset} of the chunk is not the listed message of connection {number}"
                )
            offsets.add(offset)
        indexed[number] = indexed.get(number, 0) + len(offsets)
        position = end
    if indexed != counts:
        raise RecordingError(
            f"it lists {counted(sum(indexed.values()), 'message')}, but the chunk has {sum(counts.values())}"
        )
