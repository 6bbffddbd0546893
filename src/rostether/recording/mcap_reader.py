"""Reads MCAP files with messages of ROS 1 or ROS 2, whoever wrote them, closed or not.

Source: mcap.dev/spec
"""

from __future__ import annotations

import contextlib
import mmap
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.errors import RecordingError
from rostether.recording.chunk_order import MAX_LISTED_BYTES, Entry, Unpacked, in_order
from rostether.recording.compression import NONE, decompress
from rostether.recording.mcap_content import StoredChunk, messages_in, read_content
from rostether.recording.mcap_records import Channel, Schema
from rostether.recording.recorded import (
    CompressionShare,
    Connection,
    RecordedMessage,
    Ros2Origin,
    Wanted,
)

if TYPE_CHECKING:
    from rostether.recording.ros2_reading import Ros2Topics

_ENCODING = "ros1"


class McapReader:
    """An MCAP file being read; see `recording.recorded.RecordingReader`.

    Only messages of ROS 1 and CDR are given; the latter as ROS 1 bytes, in ROS 2's own fields if `is_native`.
    `unpack` undoes the compression of single messages, as a ROS 2 bag's summary tells it.
    With `damage`, which is then why, its index is not trusted.
    Where there is no md5sum of a type, it is computed from the definition.
    """

    def __init__(
        self,
        path: Path,
        *,
        is_native: bool = False,
        unpack: Callable[[bytes], bytes] | None = None,
        damage: str = "",
    ) -> None:
        self.path = path
        self._unpack_message = unpack
        self._is_native = is_native
        self._ros2: Ros2Topics | None = None
        try:
            descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
            try:
                self.size_bytes = os.fstat(descriptor).st_size
                if not self.size_bytes:
                    raise RecordingError(f"{path} is empty")
                self._data = mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
            finally:
                os.close(descriptor)
        except OSError as error:
            raise RecordingError(f"cannot read {path}: {error.strerror or error}") from None
        self._view = memoryview(self._data)
        try:
            self._content = read_content(self._view, damage)
        except RecordingError as error:
            self.close()
            raise RecordingError(f"{path}: {error}") from None
        self._connections: dict[int, Connection] = {}
        for number, channel in self._content.channels.items():
            connection = self._connection(self._content.schemas.get(channel.schema), channel)
            if connection is not None:
                self._connections[number] = connection

    @property
    def damage(self) -> str:
        """Why the file had to be searched for its messages, or an empty string."""
        return self._content.damage

    @property
    def format_version(self) -> str:
        """The format's name, and ROS 2 where its messages are of that."""
        return "MCAP" if self._ros2 is None else "MCAP (ROS 2)"

    @property
    def unreadable(self) -> Mapping[str, str]:
        """Topics with messages that cannot be given, and why."""
        return {} if self._ros2 is None else self._ros2.unreadable

    @property
    def profile(self) -> str:
        """What its header says about its messages, such as `ros1`."""
        return self._content.profile

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        counts: Counter[Connection] = Counter()
        for number, connection in self._connections.items():
            counts[connection] += self._content.counts.get(number, 0)
        return counts

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message; None in an empty file."""
        return self._content.span_ns

    @property
    def compressions(self) -> Sequence[CompressionShare]:
        """How the chunks are compressed, the most frequent first."""
        by_name: dict[str, list[StoredChunk]] = {}
        for each in self._content.chunks:
            by_name.setdefault(each.compression or NONE, []).append(each)
        shares = (
            CompressionShare(
                name,
                len(chunks),
                sum(each.size_bytes for each in chunks),
                sum(each.data_end - each.data_start for each in chunks),
            )
            for name, chunks in by_name.items()
        )
        return sorted(shares, key=lambda share: -share.chunk_count)

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages in the order of their times, both ends included. Raises RecordingError."""
        connections = {
            number: connection
            for number, connection in self._connections.items()
            if wanted is None or wanted(connection)
        }
        chunks = [
            chunk
            for chunk in self._content.chunks
            if (chunk.channels is None or not connections.keys().isdisjoint(chunk.channels))
            and (end_ns is None or chunk.start_ns <= end_ns)
            and (start_ns is None or chunk.end_ns >= start_ns)
        ]
        found = in_order(chunks, partial(self._unpack, connections), start_ns=start_ns, end_ns=end_ns)
        try:
            for number, time_ns, payload in found:
                connection = connections[number]
                if connection.origin is None or self._ros2 is None:
                    yield RecordedMessage(connection, time_ns, payload)
                    continue
                cdr = payload if self._unpack_message is None else self._unpack_message(payload)
                converted = self._ros2.convert(connection, cdr)
                if converted is not None:
                    yield RecordedMessage(connection, time_ns, converted)
        except RecordingError as error:
            raise RecordingError(
                f"{self.path}: {error}; `rostether bag reindex` keeps what is whole"
            ) from None

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._view.release()
        with contextlib.suppress(BufferError):  # a reading that was left holds a part of it, and frees it
            self._data.close()

    def _unpack(self, connections: Mapping[int, Connection], chunk: StoredChunk) -> Unpacked:
        stored = self._view[chunk.data_start : chunk.data_end]
        plain = decompress(chunk.compression, stored, chunk.size_bytes)
        if len(plain) <= MAX_LISTED_BYTES:
            plain = bytes(plain)  # a slice of bytes costs half of what one of a view does

        def walk() -> Iterator[Entry]:
            for entry in messages_in(plain):
                if entry[3] in connections:
                    yield entry

        return plain, walk

    def _connection(self, schema: Schema | None, channel: Channel) -> Connection | None:
        """Return what a channel is to us; None when its messages cannot be given."""
        name = schema.name if schema is not None else "*"
        if channel.encoding == "cdr" and schema is not None:
            return self._ros2_connection(schema, channel)
        if channel.encoding != _ENCODING:
            return None
        definition = schema.data.decode("utf-8", "surrogateescape") if schema is not None else ""
        md5sum = channel.metadata.get("md5sum") or _md5sum(name, definition)
        told = {"type": name, "md5sum": md5sum, "message_definition": definition}
        if channel.metadata.get("latching") == "true":
            told["latching"] = "1"
        return Connection.from_fields(channel.topic, {**channel.metadata, **told})

    def _ros2_connection(self, schema: Schema, channel: Channel) -> Connection | None:
        if self._ros2 is None:
            from rostether.recording.ros2_reading import Ros2Topics

            self._ros2 = Ros2Topics(is_native=self._is_native)
        origin = Ros2Origin(
            schema.name,
            channel.metadata.get("topic_type_hash", ""),
            schema.encoding,
            schema.data.decode("utf-8", "surrogateescape"),
        )
        return self._ros2.connection(channel.topic, origin, channel.metadata.get("offered_qos_profiles"))


def _md5sum(name: str, definition: str) -> str:
    from rostether.errors import RostetherError
    from rostether.msgdef.registry import Registry

    try:
        registry = Registry(bundled=False)
        registry.add_full_text(name, definition)
        return registry.message_type(name).md5sum
    except RostetherError:
        return "*"
