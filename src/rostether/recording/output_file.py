"""An append-only file, truncated to its last complete part if the disk is full."""

from __future__ import annotations

import os
from pathlib import Path

from rostether.errors import RecordingError


class OutputFile:
    """Appends to a file; `position` is the end of the last complete part."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.position = 0
        flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
        try:
            self._file: int | None = os.open(path, flags, 0o666)
        except OSError as error:
            raise RecordingError(
                f"cannot write {path}: {error.strerror or error}; choose a file in a writable folder"
            ) from None

    def append(self, data: bytes) -> None:
        """Write a complete part, or restore the file and raise RecordingError."""
        try:
            self._write(data)
        except OSError as error:
            self._cut()
            raise RecordingError(f"cannot write {self.path}: {error.strerror or error}") from None
        self.position += len(data)

    def replace(self, position: int, data: bytes) -> None:
        """Overwrite existing bytes. Raises RecordingError."""
        assert self._file is not None
        try:
            os.lseek(self._file, position, os.SEEK_SET)
            self._write(data)
            os.lseek(self._file, self.position, os.SEEK_SET)
        except OSError as error:
            raise RecordingError(f"cannot write {self.path}: {error.strerror or error}") from None

    def close(self) -> None:
        """Close the file. Idempotent."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _write(self, data: bytes) -> None:
        assert self._file is not None
        view = memoryview(data)
        while view:
            view = view[os.write(self._file, view) :]

    def _cut(self) -> None:
        assert self._file is not None
        try:
            os.ftruncate(self._file, self.position)
            os.lseek(self._file, self.position, os.SEEK_SET)
        except OSError:  # devices cannot be truncated; readers find the last complete part themselves
            return
