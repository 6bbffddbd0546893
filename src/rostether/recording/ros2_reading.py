"""The common part of readers of ROS 2 recordings: topics as connections, and CDR as ROS 1 bytes."""

from __future__ import annotations

from collections.abc import Callable

from rostether.errors import RostetherError, SerializationError
from rostether.recording.recorded import Connection, Ros2Origin
from rostether.recording.ros2_qos import is_latching, profiles_text, read_profiles
from rostether.recording.ros2_types import ReadTypes

CDR = "cdr"


class RecordedTopics:
    """The topics of one ROS 2 recording; `is_native` as for `ReadTypes`."""

    def __init__(self, *, is_native: bool) -> None:
        # Topics with messages that cannot be converted, and why.
        self.unreadable: dict[str, str] = {}
        self._types = ReadTypes(is_native=is_native)
        self._convert: dict[Connection, Callable[[bytes], bytes]] = {}

    def connection(self, topic: str, origin: Ros2Origin, qos: object) -> Connection | None:
        """Return a topic as a connection, None if its type cannot be read: `unreadable` has the reason."""
        profiles = read_profiles(qos)
        origin = Ros2Origin(
            origin.type_name, origin.type_hash, origin.encoding, origin.definition, profiles_text(profiles)
        )
        try:
            read = self._types.of(origin)
        except RostetherError as error:
            self.unreadable[topic] = str(error)
            return None
        connection = Connection(topic, read.type, "", is_latching(profiles), origin)
        self._convert[connection] = read.from_cdr
        return connection

    def convert(self, connection: Connection, cdr: bytes) -> bytes | None:
        """Return a message as ROS 1 bytes, None if it does not fit its type: `unreadable` has the reason."""
        try:
            return self._convert[connection](cdr)
        except SerializationError as error:
            self.unreadable.setdefault(connection.topic, f"a message does not fit its type: {error}")
            return None
