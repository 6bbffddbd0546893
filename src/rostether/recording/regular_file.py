"""Opens and maps regular files only: opening a FIFO may never return, and devices have no end."""

from __future__ import annotations

import contextlib
import mmap
import os
import stat
from pathlib import Path

from rostether.errors import RecordingError
from rostether.mechanisms.text import read_failure

SQLITE_MAGIC = b"SQLite format 3\0"

# SQLite leaves these log files if the disk is full at the end; without them, the database is incomplete.
_LOG_SUFFIXES = ("-wal", "-shm", "-journal")

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a FIFO"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def require_regular_file(path: Path) -> None:
    """Raise RecordingError if the path exists and is not a regular file; opening it reports a missing one."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    for is_such, kind in _KINDS:
        if is_such(mode):
            raise RecordingError(f"{path} is {kind}, not a file; give a recording or a ROS 2 bag")


def sqlite_logs(path: Path) -> list[Path]:
    """Return the paths of the log files that a database may have."""
    return [path.with_name(path.name + suffix) for suffix in _LOG_SUFFIXES]


def remove_database(path: Path) -> None:
    """Remove a database and its log files, if they exist."""
    for each in (path, *sqlite_logs(path)):
        each.unlink(missing_ok=True)


class MappedFile:
    """The bytes of a file as `view`. Raises RecordingError if it cannot be read or is empty."""

    def __init__(self, path: Path) -> None:
        require_regular_file(path)
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
            raise RecordingError(read_failure(path, error)) from None
        self.view = memoryview(self._data)

    def close(self) -> None:
        """Close the file. Idempotent."""
        self.view.release()
        # An unfinished iterator has a view of the data, and frees it later.
        with contextlib.suppress(BufferError):
            self._data.close()
