"""Reads the SQLite files of rosbag2 (.db3), of every version of their schema."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from rostether.errors import RecordingError
from rostether.mechanisms.text import first_line, read_failure
from rostether.msgdef.full_text import MAX_FULL_TEXT_CHARACTERS
from rostether.recording.compression import CompressionShare, StoredChunk
from rostether.recording.recorded import Connection, RecordedMessage, Ros2Origin, Wanted, wanted_connections
from rostether.recording.regular_file import SQLITE_MAGIC, require_regular_file
from rostether.recording.ros2_types import CDR, RecordedTopics

# The limit of topics and of definitions; recordings of the largest robots have a few thousand.
MAX_TOPICS = 65536
# The largest message that is read; equal to SQLite's own limit.
MAX_VALUE_BYTES = 1 << 30


class Db3Reader:
    """A .db3 file being read; see `recording.recorded.RecordingReader`.

    Messages are returned as ROS 1 bytes, with the fields of ROS 2 if `is_native`. `unpack` decompresses
    messages that a ROS 2 bag compresses one by one. Raises RecordingError if the file is not a recording.
    """

    format_version = "rosbag2 (sqlite3)"
    chunks: Sequence[StoredChunk] = ()
    compressions: Sequence[CompressionShare] = ()

    def __init__(
        self, path: Path, *, is_native: bool = False, unpack: Callable[[bytes], bytes] | None = None
    ) -> None:
        self.path = path
        self.damage = ""
        self._unpack = unpack
        self._topics = RecordedTopics(is_native=is_native)
        self._connections: dict[int, Connection] = {}
        self._counts: Counter[Connection] = Counter()
        require_regular_file(path)
        try:
            self.size_bytes = path.stat().st_size
            with path.open("rb") as file:
                begin = file.read(len(SQLITE_MAGIC))
                if not begin:
                    raise RecordingError(f"{path} is empty")
                if begin != SQLITE_MAGIC:
                    raise RecordingError(f"{path} is not a SQLite file, as a .db3 recording must be")
        except OSError as error:
            raise RecordingError(read_failure(path, error)) from None
        # If the recording was not closed, its last messages are in a log file, which SQLite merges when it
        # reads.
        has_log = (
            path.with_name(path.name + "-wal").exists() or path.with_name(path.name + "-journal").exists()
        )
        mode = "mode=rw" if has_log else "mode=ro&immutable=1"
        try:
            self._database = sqlite3.connect(f"{path.absolute().as_uri()}?{mode}", uri=True)
        except sqlite3.Error as error:
            raise RecordingError(read_failure(path, error)) from None
        try:
            # Views and triggers of an untrusted file must not run.
            self._database.execute("PRAGMA trusted_schema = OFF")
            self._database.text_factory = lambda data: data.decode("utf-8", "replace")
            self._database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_VALUE_BYTES)
            self._check_tables()
            self._read_topics()
            self.span_ns = self._read_span()
        except (sqlite3.Error, TypeError, ValueError) as error:
            self.close()
            reason = first_line(error)
            if isinstance(error, UnicodeDecodeError):
                reason = "it contains text that is not UTF-8"
            raise RecordingError(f"{path} is not a recording of rosbag2, or is broken: {reason}") from None

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        return self._counts

    @property
    def unreadable(self) -> Mapping[str, str]:
        """Topics with messages that cannot be converted, and why."""
        return self._topics.unreadable

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive. Raises RecordingError."""
        connections = wanted_connections(self._connections, wanted)
        # Without limits there is no condition: a damaged time in the index must not hide other messages.
        limits = {"timestamp >= ?": start_ns, "timestamp <= ?": end_ns}
        given = {condition: time_ns for condition, time_ns in limits.items() if time_ns is not None}
        query = "SELECT topic_id, timestamp, data FROM messages"
        if given:
            query += f" WHERE {' AND '.join(given)}"
        try:
            for number, time_ns, data in self._database.execute(
                f"{query} ORDER BY timestamp, id", tuple(given.values())
            ):
                connection = connections.get(number)
                if connection is None or not isinstance(data, bytes) or not isinstance(time_ns, int):
                    continue
                payload = self._topics.convert(
                    connection, data if self._unpack is None else self._unpack(data)
                )
                if payload is not None:
                    yield RecordedMessage(connection, time_ns, payload)
        except sqlite3.Error as error:
            raise RecordingError(f"{self.path}: {first_line(error)}") from None

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._database.close()

    def _check_tables(self) -> None:
        # A view or virtual table does not count: it could be endless, even in a small file.
        tables = {
            name
            for (name,) in self._database.execute(
                "SELECT name FROM sqlite_schema WHERE type = 'table' AND sql NOT LIKE 'CREATE VIRTUAL%'"
            )
        }
        if not {"topics", "messages"} <= tables:
            raise ValueError("it has no tables of topics and messages")
        self._has_definitions = "message_definitions" in tables

    def _read_topics(self) -> None:
        columns = {row[1] for row in self._database.execute("PRAGMA table_info(topics)")}
        if not {"id", "name", "type", "serialization_format"} <= columns:
            raise ValueError("it has no table of topics")
        definitions = self._read_definitions()
        qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
        type_hash = "type_description_hash" if "type_description_hash" in columns else "''"
        rows = self._database.execute(
            f"SELECT id, name, type, serialization_format, {qos}, {type_hash} FROM topics"  # noqa: S608
            f" WHERE length(name) + length(type) + length({qos}) <= ? LIMIT ?",
            (MAX_FULL_TEXT_CHARACTERS, MAX_TOPICS),
        ).fetchall()
        counts = dict(self._database.execute("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"))
        for number, topic, type_name, encoding, offers, digest in rows:
            name, topic = str(type_name), str(topic)
            if encoding != CDR:
                self._topics.unreadable[topic] = f"its messages are {encoding}, not {CDR}"
                continue
            schema = definitions.get((name, str(digest))) or definitions.get((name, "")) or ("", "")
            connection = self._topics.connection(topic, Ros2Origin(name, str(digest), *schema), offers)
            if connection is not None:
                self._connections[number] = connection
                self._counts[connection] += counts.get(number, 0)

    def _read_definitions(self) -> dict[tuple[str, str], tuple[str, str]]:
        if not self._has_definitions:
            return {}  # before Iron
        rows = self._database.execute(
            "SELECT topic_type, type_description_hash, encoding, encoded_message_definition"
            " FROM message_definitions WHERE length(encoded_message_definition) <= ? LIMIT ?",
            (MAX_FULL_TEXT_CHARACTERS, MAX_TOPICS),
        ).fetchall()
        found = {(str(row[0]), str(row[1])): (str(row[2]), str(row[3])) for row in rows}
        return found | {(name, ""): schema for (name, _), schema in found.items()}

    def _read_span(self) -> tuple[int, int] | None:
        start_ns, end_ns = self._database.execute(
            "SELECT (SELECT min(timestamp) FROM messages), (SELECT max(timestamp) FROM messages)"
        ).fetchone()
        return None if start_ns is None or end_ns is None else (int(start_ns), int(end_ns))
