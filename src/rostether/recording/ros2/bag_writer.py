"""Writes ROS 2 bags: folders with one or more message files and metadata.yaml, in the layout of rosbag2."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Protocol

from rostether.errors import RecordingError
from rostether.mechanisms.text import write_failure
from rostether.recording.chunked_writer import DEFAULT_CHUNK_BYTES
from rostether.recording.compression import NONE
from rostether.recording.file_lock import ACTIVE_SUFFIX
from rostether.recording.recorded import Connection, RecordingWriter
from rostether.recording.ros2.channels import Ros2Channels, UnfitMessages, distro_of
from rostether.recording.ros2.metadata import FileFacts, describe, write_metadata
from rostether.ros2.types.type_support import Ros2Types


class Storage(StrEnum):
    """The storage formats of a ROS 2 bag, by their names in rosbag2."""

    MCAP = "mcap"
    SQLITE3 = "sqlite3"

    @property
    def suffix(self) -> str:
        """The suffix of its files."""
        return ".mcap" if self is Storage.MCAP else ".db3"


class FileStorage(RecordingWriter, Protocol):
    """The writer of one file, with its contents."""

    @property
    def channels(self) -> Ros2Channels:
        """The file's topics."""

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message."""

    def topic_counts(self) -> dict[int, int]:
        """Return the number of messages by channel number."""


class Ros2Bag:
    """A bag being written, file after file; metadata.yaml lists the files that are closed.

    Raises RecordingError if the folder is not empty or cannot be created.
    """

    def __init__(
        self,
        folder: Path,
        storage: Storage = Storage.MCAP,
        *,
        compression: str = NONE,
        chunk_bytes: int = DEFAULT_CHUNK_BYTES,
        types: Ros2Types | None = None,
        unfit: UnfitMessages | None = None,
    ) -> None:
        self.folder = folder
        self.storage = storage
        self._compression = compression
        self._chunk_bytes = chunk_bytes
        self._types = types
        self._unfit = unfit
        self._files: list[FileFacts] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise RecordingError(f"{folder} is not empty; a ROS 2 bag needs a new folder")
        except OSError as error:
            raise RecordingError(write_failure(folder, error)) from None

    def path_of(self, number: int) -> Path:
        """Return the path of the file with a number, as rosbag2 names it."""
        return self.folder / f"{self.folder.name}_{number}{self.storage.suffix}"

    def create(self, path: Path) -> Ros2FileWriter:
        """Start a file; it may be named NAME.active until it is closed. Raises RecordingError."""
        return Ros2FileWriter(self, path)

    def open_storage(self, path: Path) -> FileStorage:
        """Return the writer of one file. Raises RecordingError, ConfigError."""
        if self.storage is Storage.MCAP:
            from rostether.recording.ros2.mcap_writer import Ros2McapWriter

            return Ros2McapWriter(
                path,
                compression=self._compression,
                chunk_bytes=self._chunk_bytes,
                types=self._types,
                unfit=self._unfit,
            )
        from rostether.recording.ros2.db3_writer import Db3Writer

        return Db3Writer(path, types=self._types, unfit=self._unfit)

    def add_file(self, facts: FileFacts) -> None:
        """Add a file to metadata.yaml, and remove entries of deleted files. Raises RecordingError."""
        self._files = [each for each in self._files if (self.folder / each.name).exists()]
        self._files.append(facts)
        write_metadata(self.folder, describe(self._files, self.storage.value, distro_of(self._types)))


class Ros2FileWriter:
    """One file of a bag; see `recording.recorded.RecordingWriter`."""

    def __init__(self, bag: Ros2Bag, path: Path) -> None:
        self._bag = bag
        self._name = path.name.removesuffix(ACTIVE_SUFFIX)
        self._storage = bag.open_storage(path)
        self._is_closed = False

    @property
    def size_bytes(self) -> int:
        """The approximate size of the file with all accepted messages."""
        return self._storage.size_bytes

    @property
    def message_count(self) -> int:
        """The number of accepted messages."""
        return self._storage.message_count

    def add_connection(self, connection: Connection) -> int:
        """Add a connection if it is new; return its number. Raises RecordingError."""
        return self._storage.add_connection(connection)

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at one time. Raises RecordingError."""
        self._storage.write(number, time_ns, payloads)

    def flush(self) -> None:
        """Pass all accepted messages to the operating system. Raises RecordingError."""
        self._storage.flush()

    def close(self) -> None:
        """Close the file, and add it to metadata.yaml. Idempotent. Raises RecordingError."""
        if self._is_closed:
            return
        self._is_closed = True
        self._storage.close()
        counts = self._storage.topic_counts()
        span_ns = self._storage.span_ns
        topics = {
            (each.topic, each.origin.type_name): (each.origin, counts[each.number])
            for each in self._storage.channels.channels
        }
        start_ns, end_ns = span_ns or (None, 0)
        self._bag.add_file(FileFacts(self._name, start_ns, end_ns, topics))
