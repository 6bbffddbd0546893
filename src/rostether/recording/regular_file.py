"""Opens and maps regular files only: opening a FIFO may never return, and devices have no end."""

from __future__ import annotations

import contextlib
import mmap
import os
import stat
import weakref
from pathlib import Path

from rostether.errors import RecordingError
from rostether.mechanisms.text import read_failure
from rostether.recording.compression import MAX_LISTED_BYTES, Buffer

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
            self._descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
            self._close_file = weakref.finalize(self, os.close, self._descriptor)
            self.size_bytes = os.fstat(self._descriptor).st_size
            if not self.size_bytes:
                raise RecordingError(f"{path} is empty")
            self._data = mmap.mmap(self._descriptor, 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise RecordingError(read_failure(path, error)) from None
        self.view = memoryview(self._data)

    def read(self, start: int, end: int) -> Buffer:
        """Return a part of the file. Raises RecordingError if it cannot be read any more.

        If another program shortens the file, or its disk is unplugged, the next access to `view` ends the
        process with SIGBUS. This method reports it, except for large parts.
        """
        part = self.view[start:end]
        if end - start > MAX_LISTED_BYTES or not hasattr(os, "pread"):
            return part
        try:
            data = os.pread(self._descriptor, end - start, start)
        except OSError as error:
            raise RecordingError(f"it cannot be read any more ({error.strerror})") from None
        if len(data) < end - start:
            raise RecordingError("another program has shortened it")
        return data

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._close_file()
        self.view.release()
        # An unfinished iterator has a view of the data, and frees it later.
        with contextlib.suppress(BufferError):
            self._data.close()
