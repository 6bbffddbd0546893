"""Reads MCAP files with messages of ROS 1 or ROS 2, from any program, closed or not.

Source: mcap.dev/spec
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.recording.chunked_reader import ChunkedReader
from rostether.recording.mcap.content import McapContent, messages_in, read_content
from rostether.recording.mcap.records import Channel, Schema
from rostether.recording.recorded import Connection, RecordedMessage, Ros2Origin, Wanted

if TYPE_CHECKING:
    from rostether.recording.ros2_types import RecordedTopics

_ENCODING = "ros1"


class McapReader(ChunkedReader[McapContent]):
    """An MCAP file being read; see `recording.recorded.RecordingReader`.

    Only ROS 1 and CDR messages are returned; CDR is converted to ROS 1 bytes, with the fields of ROS 2 if
    `is_native`. `unpack` decompresses messages that a ROS 2 bag compresses one by one. `damage`, if given, is
    the reason not to use the index. A missing md5sum of a type is computed from the definition. Raises
    RecordingError if the file is not MCAP.
    """

    def __init__(
        self,
        path: Path,
        *,
        is_native: bool = False,
        unpack: Callable[[bytes], bytes] | None = None,
        damage: str = "",
    ) -> None:
        super().__init__(path, lambda view: read_content(view, damage), messages_in)
        self._unpack_message = unpack
        self._is_native = is_native
        self._ros2: RecordedTopics | None = None
        self._connections: dict[int, Connection] = {}
        for number, channel in self._content.channels.items():
            connection = self._connection(self._content.schemas.get(channel.schema), channel)
            if connection is not None:
                self._connections[number] = connection

    @property
    def format_version(self) -> str:
        """The format's name, with "ROS 2" if it has ROS 2 messages."""
        return "MCAP" if self._ros2 is None else "MCAP (ROS 2)"

    @property
    def unreadable(self) -> Mapping[str, str]:
        """Topics with messages that cannot be converted, and why."""
        return {} if self._ros2 is None else self._ros2.unreadable

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

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive. Raises RecordingError."""
        found = super().messages(wanted, start_ns=start_ns, end_ns=end_ns)
        return found if self._ros2 is None else self._converted(self._ros2, found)

    def _converted(
        self, topics: RecordedTopics, found: Iterator[RecordedMessage]
    ) -> Iterator[RecordedMessage]:
        for message in found:
            connection, time_ns, payload = message
            if connection.origin is None:
                yield message
                continue
            cdr = payload if self._unpack_message is None else self._unpack_message(payload)
            converted = topics.convert(connection, cdr)
            if converted is not None:
                yield RecordedMessage(connection, time_ns, converted)

    def _connection(self, schema: Schema | None, channel: Channel) -> Connection | None:
        """Return a channel as a connection; None if its messages cannot be converted."""
        name = schema.name if schema is not None else "*"
        if channel.encoding == "cdr" and schema is not None:
            return self._ros2_connection(schema, channel)
        if channel.encoding != _ENCODING:
            return None
        definition = schema.data.decode("utf-8", "surrogateescape") if schema is not None else ""
        md5sum = channel.metadata.get("md5sum") or _md5sum(name, definition)
        fields = {"type": name, "md5sum": md5sum, "message_definition": definition}
        if channel.metadata.get("latching") == "true":
            fields["latching"] = "1"
        return Connection.from_fields(channel.topic, {**channel.metadata, **fields})

    def _ros2_connection(self, schema: Schema, channel: Channel) -> Connection | None:
        if self._ros2 is None:
            from rostether.recording.ros2_types import RecordedTopics

            self._ros2 = RecordedTopics(is_native=self._is_native)
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
        return Registry.of_full_text(name, definition).message_type(name).md5sum
    except RostetherError:
        return "*"
