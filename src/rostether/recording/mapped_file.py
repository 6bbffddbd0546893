"""A file mapped into memory, so that only the accessed parts are loaded."""

from __future__ import annotations

import contextlib
import mmap
import os
from pathlib import Path

from rostether.errors import RecordingError
from rostether.recording.regular_file import require_regular_file


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
            raise RecordingError(f"cannot read {path}: {error.strerror or error}") from None
        self.view = memoryview(self._data)

    def close(self) -> None:
        """Close the file. Idempotent."""
        self.view.release()
        with contextlib.suppress(BufferError):  # an unfinished iterator holds a view and frees it later
            self._data.close()
