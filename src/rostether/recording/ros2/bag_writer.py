"""Writes ROS 2 bags: folders with one or more message files and metadata.yaml, in the layout of rosbag2."""

from __future__ import annotations

from pathlib import Path

from rostether.errors import RecordingError
from rostether.recording.chunked_writer import DEFAULT_CHUNK_BYTES
from rostether.recording.compression import NONE
from rostether.recording.recorded import RecordingWriter
from rostether.recording.ros2.channels import UnfitMessages, distro_of
from rostether.recording.ros2.metadata import FileFacts, describe, write_metadata
from rostether.recording.write_errors import writing
from rostether.ros2.types.type_support import Ros2Types

# The suffix of the files in each storage format of rosbag2.
_SUFFIXES = {"mcap": ".mcap", "sqlite3": ".db3"}


class Ros2Bag:
    """A bag being written, file after file; metadata.yaml lists the files that are closed.

    `storage` is `mcap` or `sqlite3`. Raises RecordingError if the folder is not empty or cannot be created.
    """

    def __init__(
        self,
        folder: Path,
        storage: str = "mcap",
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
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise RecordingError(f"{folder} is not empty; a ROS 2 bag needs a new folder")

    def path_of(self, number: int) -> Path:
        """Return the path of the file with a number, as rosbag2 names it."""
        return self.folder / f"{self.folder.name}_{number}{_SUFFIXES[self.storage]}"

    def create(self, path: Path) -> RecordingWriter:
        """Start a file, which may be NAME.active until it is closed. Raises RecordingError, ConfigError."""
        if self.storage == "mcap":
            from rostether.recording.ros2.mcap_writer import Ros2McapWriter

            return Ros2McapWriter(
                path,
                compression=self._compression,
                chunk_bytes=self._chunk_bytes,
                types=self._types,
                unfit=self._unfit,
                on_close=self._add_file,
            )
        from rostether.recording.ros2.db3_writer import Db3Writer

        return Db3Writer(path, types=self._types, unfit=self._unfit, on_close=self._add_file)

    def _add_file(self, facts: FileFacts) -> None:
        """Add a file to metadata.yaml, and remove entries of deleted files. Raises RecordingError."""
        self._files = [each for each in self._files if (self.folder / each.name).exists()]
        self._files.append(facts)
        write_metadata(self.folder, describe(self._files, self.storage, distro_of(self._types)))
