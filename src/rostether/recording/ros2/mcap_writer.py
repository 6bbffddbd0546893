"""Writes MCAP files as rosbag2 does: profile `ros2`, messages in CDR, schemas `ros2msg`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rostether.recording.mcap.writer import McapWriter
from rostether.recording.recorded import Connection
from rostether.recording.ros2.channels import Ros2Channels, UnfitMessages
from rostether.recording.ros2.metadata import FileFacts
from rostether.ros2.types.type_support import Ros2Types


class Ros2McapWriter(McapWriter):
    """An MCAP file with ROS 2 messages being written, from ROS 1 bytes, like every recording.

    `types` and `unfit` as for `Ros2Channels`; `on_close` gets the contents of the file.
    """

    profile = "ros2"

    def __init__(
        self,
        path: Path,
        *,
        compression: str,
        chunk_bytes: int,
        types: Ros2Types | None,
        unfit: UnfitMessages | None,
        on_close: Callable[[FileFacts], None] | None = None,
    ) -> None:
        super().__init__(path, compression=compression, chunk_bytes=chunk_bytes)
        self._ros2_channels = Ros2Channels(types, unfit)
        self._on_close = on_close

    def schema_of(self, connection: Connection) -> tuple[str, str, bytes]:
        """Return name, encoding and definition of a connection's type."""
        origin = self._ros2_channels.channel(connection).origin
        return origin.type_name, origin.encoding, origin.definition.encode("utf-8", "surrogateescape")

    def channel_of(self, connection: Connection) -> tuple[str, Mapping[str, str]]:
        """Return how a connection's messages are encoded, and its metadata."""
        origin = self._ros2_channels.channel(connection).origin
        return "cdr", {"offered_qos_profiles": origin.qos, "topic_type_hash": origin.type_hash}

    def add_connection(self, connection: Connection) -> int:
        """Add the topic if it is new; return its channel number.

        Raises RecordingError if ROS 2 has no such type, or beyond 65535 topics.
        """
        known = len(self._ros2_channels.channels)
        channel = self._ros2_channels.channel(connection)
        if channel.number > known:
            super().add_connection(connection)
        return channel.number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at the same time. Raises RecordingError if the disk rejects them."""
        cdr = self._ros2_channels.converted(self._ros2_channels.channels[number - 1], payloads)
        super().write(number, time_ns, cdr)

    def close(self) -> None:
        """Write the index and close the file. Idempotent. Raises RecordingError; the chunks are kept."""
        was_closed = self._is_closed
        super().close()
        if self._on_close is not None and not was_closed:
            written = self._statistics()
            span_ns = (written.start_ns, written.end_ns) if written.message_count else None
            self._on_close(self._ros2_channels.facts(self.path, written.counts, span_ns))
