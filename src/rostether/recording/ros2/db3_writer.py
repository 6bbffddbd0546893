"""Writes the SQLite files of rosbag2 (.db3), in the schema used since Iron.

Source: rosbag2_storage_sqlite3, schema version 4.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from rostether.errors import RecordingError
from rostether.mechanisms.text import write_failure
from rostether.recording.recorded import Connection
from rostether.recording.regular_file import remove_database, sqlite_logs
from rostether.recording.ros2.channels import Ros2Channel, Ros2Channels, UnfitMessages, distro_of
from rostether.recording.ros2.metadata import FileFacts
from rostether.recording.write_errors import writing
from rostether.ros2.types.type_support import Ros2Types

SCHEMA_VERSION = 4

# The size of a message's row and index entry, without the payload.
_ROW_BYTES = 40
# The limits of data that waits for the next commit: about 10 ms of writing.
_MAX_WAITING_ROWS = 10_000
_MAX_WAITING_BYTES = 1 << 20
# Another program that reads the file locks it only briefly; a longer wait would block the recorder.
_LOCK_WAIT_S = 0.2
_MAX_TIME_NS = (1 << 63) - 1

_TABLES = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


class Db3Writer:
    """A .db3 file being written, from ROS 1 bytes; see `recording.recorded.RecordingWriter`.

    `types` and `unfit` as for `Ros2Channels`; `on_close` gets the contents of the file. Raises RecordingError
    if the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        *,
        types: Ros2Types | None = None,
        unfit: UnfitMessages | None = None,
        on_close: Callable[[FileFacts], None] | None = None,
    ) -> None:
        self._path = path
        self._on_close = on_close
        self._ros2_channels = Ros2Channels(types, unfit)
        self.message_count = 0
        self._span_ns: tuple[int, int] | None = None
        self._data_bytes = 0
        self._committed_bytes = 0
        self._rows: list[tuple[int, int, bytes]] = []
        self._definitions: set[tuple[str, str]] = set()
        self._is_closed = False
        # An existing file is overwritten like other recordings, but not replaced: it may be locked.
        with writing(path):
            path.write_bytes(b"")
            for log in sqlite_logs(path):
                log.unlink(missing_ok=True)
        try:
            self._database = sqlite3.connect(path, isolation_level=None, timeout=_LOCK_WAIT_S)
            self._prepare(distro_of(types))
        except sqlite3.Error as error:
            with suppress(OSError):
                remove_database(path)
            raise RecordingError(write_failure(path, error)) from None

    def _prepare(self, distro: str) -> None:
        try:
            # If the process is killed, committed data is safe; only a power failure may lose it.
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.execute("PRAGMA synchronous = OFF")
            self._database.executescript(_TABLES)
            self._database.execute("INSERT INTO schema VALUES (?, ?)", (SCHEMA_VERSION, distro))
        except sqlite3.Error:
            self._database.close()
            raise

    @property
    def size_bytes(self) -> int:
        """The approximate size of the file with all accepted messages."""
        return self._data_bytes + _ROW_BYTES * self.message_count

    def add_connection(self, connection: Connection) -> int:
        """Add the topic if it is new; return the number of its row.

        Raises RecordingError if ROS 2 has no such type, or the disk rejects the topic.
        """
        known = len(self._ros2_channels.channels)
        channel = self._ros2_channels.channel(connection)
        if channel.number > known:
            self._add_topic(channel)
        return channel.number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at the same time. Raises RecordingError if the disk rejects them."""
        cdr = self._ros2_channels.converted(self._ros2_channels.channels[number - 1], payloads)
        if not cdr:
            return
        time_ns = min(max(time_ns, 0), _MAX_TIME_NS)
        self._rows += [(number, time_ns, each) for each in cdr]
        self._data_bytes += sum(map(len, cdr))
        self.message_count += len(cdr)
        start_ns, end_ns = self._span_ns or (time_ns, time_ns)
        self._span_ns = (min(start_ns, time_ns), max(end_ns, time_ns))
        if (
            len(self._rows) >= _MAX_WAITING_ROWS
            or self._data_bytes - self._committed_bytes >= _MAX_WAITING_BYTES
        ):
            self.flush()

    def flush(self) -> None:
        """Commit all accepted messages. On RecordingError, the file keeps its previous content."""
        rows, self._rows = self._rows, []
        self._committed_bytes = self._data_bytes
        if not rows or self._is_closed:
            return
        try:
            self._database.execute("BEGIN")
            self._database.executemany(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows
            )
            self._database.execute("COMMIT")
        except sqlite3.Error as error:
            if self._database.in_transaction:
                self._database.rollback()
            self.message_count -= len(rows)
            for number, _, _ in rows:
                self._ros2_channels.channels[number - 1].message_count -= 1
            raise RecordingError(write_failure(self._path, error)) from None

    def close(self) -> None:
        """Commit all messages, and merge the log into the file. Idempotent. Raises RecordingError."""
        if self._is_closed:
            return
        try:
            self.flush()
            with writing(self._path, sqlite3.Error):
                self._merge_log()
        finally:
            self._is_closed = True
            self._database.close()
        if self._on_close is not None:
            counts = {each.number: each.message_count for each in self._ros2_channels.channels}
            self._on_close(self._ros2_channels.facts(self._path, counts, self._span_ns))

    def _merge_log(self) -> None:
        try:
            self._database.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.OperationalError:
            # Another program is reading it: the log may remain, but all its content is also in the file.
            self._database.execute("PRAGMA wal_checkpoint(FULL)")

    def _add_topic(self, channel: Ros2Channel) -> None:
        origin = channel.origin
        with writing(self._path, sqlite3.Error):
            self._database.execute(
                "INSERT INTO topics VALUES (?, ?, ?, 'cdr', ?, ?)",
                (channel.number, channel.topic, origin.type_name, origin.qos, origin.type_hash),
            )
            if (origin.type_name, origin.type_hash) not in self._definitions:
                self._definitions.add((origin.type_name, origin.type_hash))
                self._database.execute(
                    "INSERT INTO message_definitions"
                    " (topic_type, encoding, encoded_message_definition, type_description_hash)"
                    " VALUES (?, ?, ?, ?)",
                    (origin.type_name, origin.encoding, origin.definition, origin.type_hash),
                )
