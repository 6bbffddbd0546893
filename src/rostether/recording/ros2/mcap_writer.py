"""Writes MCAP files as rosbag2 does: profile `ros2`, messages in CDR, schemas `ros2msg`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rostether.recording.mcap.writer import McapWriter
from rostether.recording.recorded import Connection
from rostether.recording.ros2.channels import Ros2Channels, UnfitMessages
from rostether.ros2.types.type_support import Ros2Types


class Ros2McapWriter(McapWriter):
    """An MCAP file with ROS 2 messages being written, from ROS 1 bytes, like every recording.

    `types` and `unfit` as for `Ros2Channels`.
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
    ) -> None:
        super().__init__(path, compression=compression, chunk_bytes=chunk_bytes)
        self.channels = Ros2Channels(types, unfit)
        self._of_connection: dict[Connection, int] = {}

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message that are in the file."""
        if not self._indexes:
            return None
        return min(each.start_ns for each in self._indexes), max(each.end_ns for each in self._indexes)

    def topic_counts(self) -> dict[int, int]:
        """Return the number of messages by channel number."""
        return {each.number: self._counts.get(each.number, 0) for each in self.channels.channels}

    def schema_of(self, connection: Connection) -> tuple[str, str, bytes]:
        """Return name, encoding and definition of a connection's type."""
        origin = self.channels.channel(connection).origin
        return origin.type_name, origin.encoding, origin.definition.encode("utf-8", "surrogateescape")

    def channel_of(self, connection: Connection) -> tuple[str, Mapping[str, str]]:
        """Return how a connection's messages are encoded, and its metadata."""
        origin = self.channels.channel(connection).origin
        return "cdr", {"offered_qos_profiles": origin.qos, "topic_type_hash": origin.type_hash}

    def add_connection(self, connection: Connection) -> int:
        """Add the topic if it is new; return its channel number.

        Raises RecordingError if ROS 2 has no such type.
        """
        number = self._of_connection.get(connection)
        if number is None:
            known = len(self.channels.channels)
            channel = self.channels.channel(connection)
            if channel.number > known:
                super().add_connection(connection)
            number = self._of_connection[connection] = channel.number
        return number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at one time. Raises RecordingError if the disk rejects them."""
        cdr = self.channels.converted(self.channels.channels[number - 1], payloads)
        super().write(number, time_ns, cdr)
