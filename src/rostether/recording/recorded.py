"""The contents of every recording, in any format: connections, and messages with their receive times."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

from msgspec import Struct

from rostether.msgdef.interface import MessageType

if TYPE_CHECKING:
    from rostether.recording.compression import CompressionShare

# The fields of a connection header that are attributes of a connection.
_OWN_FIELDS = frozenset({"callerid", "md5sum", "message_definition", "reliability", "topic", "type"})


class Ros2Origin(Struct, frozen=True):
    """A topic's properties in a ROS 2 recording: its type, and the QoS of its publishers (YAML).

    `encoding` is that of `definition`, `ros2msg` or `ros2idl`, empty if it is unknown.
    """

    type_name: str
    type_hash: str = ""
    encoding: str = ""
    definition: str = ""
    qos: str = ""


class Connection(Struct, frozen=True):
    """One publisher on one topic, as its connection header describes it; `origin` is set for ROS 2.

    `others` are the remaining header fields, which copies of a file keep. They are a `latching` of 0, which
    roscpp's publishers send, and private fields of the publisher.
    `is_best_effort` is set while a ROS 2 publisher is recorded; later, `origin` contains it.
    """

    topic: str
    type: MessageType
    caller_id: str = ""
    is_latching: bool = False
    origin: Ros2Origin | None = None
    is_best_effort: bool = False
    others: tuple[tuple[str, str], ...] = ()

    @property
    def shown_type(self) -> str:
        """The type's name for users: ROS 2's name in a recording of ROS 2."""
        return self.type.name if self.origin is None else self.origin.type_name

    @classmethod
    def from_fields(cls, topic: str, fields: Mapping[str, str]) -> Connection:
        """Build from the fields of a connection header; a missing type or md5sum is `*`."""
        message_type = MessageType(
            fields.get("type", "*"), fields.get("md5sum", "*"), fields.get("message_definition", "")
        )
        is_latching = fields.get("latching", "0") == "1"
        others = (
            (name, value)
            for name, value in sorted(fields.items())
            if name not in _OWN_FIELDS and (name != "latching" or not is_latching)
        )
        return cls(
            topic,
            message_type,
            fields.get("callerid", ""),
            is_latching,
            is_best_effort=fields.get("reliability") == "best_effort",
            others=tuple(others),
        )

    def fields(self) -> dict[str, str]:
        """Return the connection header's fields, sorted by name as in rosbag."""
        fields = {"callerid": self.caller_id} if self.caller_id else {}
        if self.is_latching:
            fields["latching"] = "1"
        fields |= {
            "md5sum": self.type.md5sum,
            "message_definition": self.type.definition,
            "topic": self.topic,
            "type": self.type.name,
        }
        return dict(sorted((*self.others, *fields.items()))) if self.others else fields


class RecordedMessage(NamedTuple):
    """One message: its ROS 1 bytes, and the time of its arrival in nanoseconds since the epoch."""

    connection: Connection
    time_ns: int
    payload: bytes


Wanted: TypeAlias = Callable[[Connection], bool]


def wanted_connections(connections: Mapping[int, Connection], wanted: Wanted | None) -> dict[int, Connection]:
    """Return the wanted connections; None means all."""
    return {number: each for number, each in connections.items() if wanted is None or wanted(each)}


class RecordingWriter(Protocol):
    """Writes a recording. Every method raises RecordingError if a write fails."""

    @property
    def size_bytes(self) -> int:
        """The approximate size of the file with all accepted messages."""

    @property
    def message_count(self) -> int:
        """How many messages were accepted."""

    def add_connection(self, connection: Connection) -> int:
        """Add a connection if it is new; return its number. Equal connections share one."""

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at the same time."""

    def flush(self) -> None:
        """Pass all accepted messages to the operating system: a killed process loses none of them."""

    def close(self) -> None:
        """Write the index and close the file. Idempotent."""


class RecordingReader(Protocol):
    """A recording being read."""

    @property
    def size_bytes(self) -> int:
        """The file's size."""

    @property
    def format_version(self) -> str:
        """The format's version, as written in the file."""

    @property
    def damage(self) -> str:
        """Why the file had to be searched for its messages, or an empty string."""

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""

    @property
    def unreadable(self) -> Mapping[str, str]:
        """Topics with messages that cannot be converted, and why; `messages` omits them.

        Messages that do not fit their type are found while reading; `counts` omits topics of unknown type.
        """

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message; None in an empty recording."""

    @property
    def compressions(self) -> Sequence[CompressionShare]:
        """How the chunks are compressed, the most frequent first."""

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive. Raises RecordingError."""

    def close(self) -> None:
        """Close the file. Idempotent."""


def merged(
    readers: Sequence[RecordingReader],
    wanted: Wanted | None,
    *,
    start_ns: int | None = None,
    end_ns: int | None = None,
) -> Iterator[RecordedMessage]:
    """Yield the messages of several recordings like one, sorted by time. Raises RecordingError."""
    streams = [each.messages(wanted, start_ns=start_ns, end_ns=end_ns) for each in readers]
    return streams[0] if len(streams) == 1 else heapq.merge(*streams, key=lambda message: message.time_ns)
