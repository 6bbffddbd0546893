"""The content of a bag, its chunks, and the messages in a chunk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from msgspec import field

from rostether.errors import RecordingError
from rostether.recording.bag.records import (
    U32,
    U32_PAIR,
    Fields,
    Op,
    decode_fields,
    op_of,
    read_record,
    time_field,
    u32_field,
)
from rostether.recording.chunk_order import Entry
from rostether.recording.chunked_reader import ChunkedContent
from rostether.recording.compression import Buffer, StoredChunk
from rostether.recording.recorded import Connection

# Ten times the connections of a fleet in a day; a compressed chunk could define millions in a few bytes.
MAX_CONNECTIONS = 100_000

# The limit for all connection headers; each one has a message definition of a few KB.
MAX_CONNECTIONS_BYTES = 256 << 20


class BagChunk(StoredChunk, frozen=True):
    """A chunk of a bag, with the number of messages of each connection."""

    counts: Mapping[int, int]


class BagContent(ChunkedContent):
    """The content of a bag."""

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[BagChunk] = field(default_factory=list)
    connections_bytes: int = 0

    def add_connection(self, fields: Fields, header: Buffer) -> None:
        """Add the connection of a record. Raises RecordingError if it is damaged or there are too many."""
        self.connections_bytes += len(header)
        if len(self.connections) >= MAX_CONNECTIONS or self.connections_bytes > MAX_CONNECTIONS_BYTES:
            limits = f"{MAX_CONNECTIONS} connections or {MAX_CONNECTIONS_BYTES >> 20} MiB of definitions"
            raise RecordingError(f"it has more than {limits}")
        named = {
            name.decode("utf-8", "surrogateescape"): value.decode("utf-8", "surrogateescape")
            for name, value in decode_fields(header).items()
        }
        topic = fields.get(b"topic", b"").decode("utf-8", "surrogateescape")
        self.connections[u32_field(fields, b"conn")] = Connection.from_fields(topic, named)


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
            if op == Op.MESSAGE:
                yield time_field(fields, b"time"), start, end, u32_field(fields, b"conn")
            elif op == Op.CONNECTION and on_connection is not None:
                on_connection(fields, plain[start:end])
        position = end
